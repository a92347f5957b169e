//! Fig. 11 on the physical plant: the turning process, with its true diameters in place of measured
//! ones.
//!
//! The paper gives neither length nor supports of the shaft it cut. `[plant]` of the inputs takes a
//! length twice the position of Fig. 11 and the main job's supports, with the paper's cutting data
//! and final diameter and a radial force scaled so that its first error is the paper's: that keeps
//! the shape, small at both ends and large in the middle, which a softer tailstock would change.

use super::control::READING;
use super::curves::{Curves, of_passes};
use super::error::ReproductionError;
use super::inputs::{Inputs, PidInput};
use crate::control::{FirstPass, OffsetForm, Pid, PidSettings};
use crate::job::Job;
use crate::plan::DiameterOffset;
use crate::process::{
    BaseForm, BelowMinimumChip, ForceLaw, MaterialSettings, PowerLaw, ProcessSettings, Stock,
    SupportSettings, TurningProcess,
};
use crate::studies::reproduction::{Accept, Row};

/// The job whose scan, masters, gauge and controller are used with frames.
const JOB: &str = include_str!("../../../configs/slender_shaft.toml");

/// Passes of Fig. 11.
pub(super) const PASSES: usize = 4;

/// The main job with the plant's shaft, cut and supports.
pub(super) fn job(inputs: &Inputs) -> Result<Job, ReproductionError> {
    let mut job: Job = toml::from_str(JOB).map_err(|e| ReproductionError::Job(e.to_string()))?;
    let (plant, cut) = (&inputs.plant, &inputs.optimum);
    let after = |left: usize| plant.final_diameter_mm + 2.0 * cut.depth_mm * left as f64;
    job.part.length_mm = plant.length_mm;
    job.part.stock_diameter_mm = after(PASSES);
    job.part.nominal_diameter_mm = (0..PASSES).rev().map(after).collect();
    job.part.aim_mm = 0.0;
    job.part.tolerance = None;
    // The paper's model has the radial force alone, on a straight shaft.
    job.shaft.bow = crate::shaft::Bow::default();
    job.cutting.speed_m_per_min = cut.speed_m_per_min;
    job.cutting.feed_mm_per_rev = cut.feed_mm_per_rev;
    let handbook = &inputs.handbook;
    job.process = ProcessSettings {
        force: ForceLaw::Power(PowerLaw {
            depth_exponent: handbook.depth_exponent,
            feed_exponent: handbook.feed_exponent,
            speed_exponent: handbook.speed_exponent,
            ..PowerLaw::default()
        }),
        material: MaterialSettings {
            youngs_modulus_n_per_mm2: Some(inputs.beam.youngs_modulus_n_per_mm2),
            poisson_ratio: Some(inputs.beam.poisson_ratio),
            ..MaterialSettings::default()
        },
        support: SupportSettings {
            chuck_n_per_um: plant.chuck_n_per_um,
            tailstock_n_per_um: plant.tailstock_n_per_um,
            ..SupportSettings::default()
        },
        ..ProcessSettings::default()
    };
    Ok(job)
}

/// How offsets follow from the controller's output.
#[derive(Clone, Copy, PartialEq)]
enum Compensation {
    None,
    Pid(OffsetForm),
}

/// Errors over z of every pass, (mm, mm of diameter).
type Profiles = Vec<Vec<(f64, f64)>>;

pub(super) fn rows(inputs: &Inputs, curves: &mut Curves) -> Result<Vec<Row>, ReproductionError> {
    let input = &inputs.pid;
    let mut job = job(inputs)?;
    let factor = identified_force(&mut job, input)?;
    let without = profiles(&job, input, Compensation::None)?;
    let absolute = profiles(&job, input, Compensation::Pid(OffsetForm::Absolute))?;
    let accumulated = profiles(&job, input, Compensation::Pid(OffsetForm::Accumulated))?;
    curves.fig_11_none = of_passes(&without, &input.uncompensated_mm, input.position_mm);
    curves.fig_11_pid = of_passes(&accumulated, &input.compensated_mm, input.position_mm);
    let assumed = format!("a shaft of {} mm, {factor:.2} times Table 1's force", job.part.length_mm);
    let mut rows = vec![Row::ours(
        ("fig11.physical.force", "radial force over Table 1's at which the first error is the paper's", ""),
        factor,
        "the paper gives neither length nor supports of the shaft it cut: identified from its first error",
    )];
    let errors = |profiles: &Profiles| -> Vec<f64> {
        profiles.iter().map(|profile| super::deflection::at_position(profile, input.position_mm)).collect()
    };
    let (none, as_printed, kept) = (errors(&without), errors(&absolute), errors(&accumulated));
    rows.extend(pass_rows("none", &none, &input.uncompensated_mm, &assumed));
    rows.extend(pass_rows("absolute", &as_printed, &input.compensated_mm, &assumed));
    rows.extend(pass_rows("accumulated", &kept, &input.compensated_mm, &assumed));
    rows.push(Row::predicted(
        ("fig11.physical.growth", "fourth over first error without control", ""),
        Some(input.uncompensated_mm[3] / input.uncompensated_mm[0]),
        none[3] / none[0],
        Accept::Relative(READING),
        &*assumed,
    ));
    rows.push(growth_at_most(&job, inputs)?);
    rows.push(gain(&job, input)?);
    for (name, errors, reason) in [
        ("absolute", &as_printed, "offsets absolute as printed in eq. 18"),
        ("accumulated", &kept, "offsets accumulated, K_i restored: the form that works"),
    ] {
        rows.push(worst(&format!("fig11.physical.{name}.worst"), errors, &input.compensated_mm, reason));
    }
    rows.push(shape("fig11.shape.none", "without control", &without));
    rows.push(shape("fig11.shape.pid", "under PID, offsets accumulated", &accumulated));
    Ok(rows)
}

/// Lengths, mm, and factors on the stiffness of the plant's supports among which the largest growth
/// is searched: from a shaft that just contains the paper's position to the paper's own 1000 mm;
/// from a tenth of the stiffness to rigid supports.
const LENGTHS_MM: [f64; 4] = [300.0, 500.0, 700.0, 1000.0];
const STIFFER: [f64; 3] = [0.1, 1.0, f64::INFINITY];

/// The largest growth of shafts of other lengths on other supports, each with the force that leaves
/// the paper's first error.
fn growth_at_most(job: &Job, inputs: &Inputs) -> Result<Row, ReproductionError> {
    let (mut most, mut held) = (0.0, String::new());
    for length_mm in LENGTHS_MM {
        for factor in STIFFER {
            let mut job = job.clone();
            job.part.length_mm = length_mm;
            job.process.support.chuck_n_per_um = inputs.plant.chuck_n_per_um * factor;
            job.process.support.tailstock_n_per_um = inputs.plant.tailstock_n_per_um * factor;
            identified_force(&mut job, &inputs.pid)?;
            let without = profiles(&job, &inputs.pid, Compensation::None)?;
            let at = |k: usize| super::deflection::at_position(&without[k], inputs.pid.position_mm);
            let growth = at(PASSES - 1) / at(0);
            if growth > most {
                most = growth;
                held = format!("at {length_mm} mm, supports {factor} times the plant's");
            }
        }
    }
    let reason = format!("{held}; lengths {LENGTHS_MM:?} mm, supports {STIFFER:?} times as stiff");
    let names =
        ("fig11.physical.growth.most", "largest growth over lengths and supports, without control", "");
    Ok(Row::ours(names, most, reason))
}

/// Change of the diameter over the change of the offset, in the second pass at the paper's
/// position.
fn gain(job: &Job, input: &PidInput) -> Result<Row, ReproductionError> {
    let stations = job.part.station_z_mm().len();
    // Small compared with the depth of cut, so that the force law is linear over it.
    let step_mm = 0.01;
    let second = |o_mm: f64| -> Result<f64, ReproductionError> {
        let mut process = workpiece(job)?;
        process.cut_profile(&job.loop_job().pass_plan(1, DiameterOffset::zero(stations)))?;
        process.cut_profile(&job.loop_job().pass_plan(2, DiameterOffset { o_mm: vec![o_mm; stations] }))?;
        let step = job.part.length_mm / (process.diameter_mm().len() - 1) as f64;
        Ok(linear(process.diameter_mm(), input.position_mm / step))
    };
    let names = ("fig11.physical.gain", "change of the diameter over the change of the offset", "");
    let gain = (second(0.0)? - second(step_mm)?) / step_mm;
    Ok(Row::ours(
        names,
        gain,
        "in the second pass, the error copying with it; offsets that replace each other need one below stability.absolute",
    ))
}

/// The largest later error over the first: at most the paper's.
pub(super) fn worst(id: &str, errors: &[f64], printed: &[f64], reason: &str) -> Row {
    let worst = |errors: &[f64]| errors[1..].iter().fold(0.0, |m: f64, e| m.max(e.abs())) / errors[0].abs();
    let (ours, paper) = (worst(errors), worst(printed));
    let names = (id, "largest later error over the first, compensated; at most the paper's", "");
    Row::predicted(names, Some(paper), ours, Accept::Range(0.0, paper), reason)
}

/// The errors of every pass at the paper's position. Without control both sides count; with it, an
/// error below the paper's agrees as well.
fn pass_rows(name: &str, errors: &[f64], printed: &[f64], assumed: &str) -> Vec<Row> {
    let row = |(k, (error, paper)): (usize, (&f64, &f64))| {
        let id = format!("fig11.physical.{name}.pass{}", k + 1);
        let quantity = format!("error after pass {}, physical plant, offsets {name}", k + 1);
        let limit = READING * errors[0];
        let names = (id.as_str(), quantity.as_str(), "mm");
        if k == 0 {
            return Row::in_sample(names, Some(*paper), *error, Accept::Absolute(limit), assumed);
        }
        let accept = match name {
            "none" => Accept::Absolute(limit),
            _ => Accept::Range(-paper - limit, paper + limit),
        };
        Row::predicted(names, Some(*paper), *error, accept, assumed)
    };
    errors.iter().zip(printed).enumerate().map(row).collect()
}

/// "Small at both ends and large in the middle": passes whose largest error lies in the middle half
/// and is above both ends'.
pub(super) fn shape(id: &str, how: &str, profiles: &[Vec<(f64, f64)>]) -> Row {
    let humped = |profile: &&Vec<(f64, f64)>| {
        let (Some(first), Some(last)) = (profile.first(), profile.last()) else { return false };
        let largest = profile.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or(first);
        let share = (largest.0 - first.0) / (last.0 - first.0);
        (0.25..=0.75).contains(&share) && largest.1.abs() > first.1.abs().max(last.1.abs())
    };
    let whole = profiles.len() as f64;
    let places: Vec<String> = profiles
        .iter()
        .filter_map(|profile| profile.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())))
        .map(|largest| format!("{:.1} µm at {:.0} mm", 1e3 * largest.1, largest.0))
        .collect();
    Row::predicted(
        (id, &format!("passes whose error is small at both ends and large in the middle, {how}"), ""),
        Some(whole),
        profiles.iter().filter(humped).count() as f64,
        Accept::Absolute(0.5),
        format!("largest errors: {}", places.join(", ")),
    )
}

/// Scales the force law so that the first error at the paper's position is the paper's, by
/// bisection over the logarithm of the factor (more force makes a larger error). Returns an end of
/// the search range where the paper's error is out of reach.
fn identified_force(job: &mut Job, input: &PidInput) -> Result<f64, ReproductionError> {
    let plain = if let ForceLaw::Power(law) = &job.process.force { *law } else { PowerLaw::default() };
    let (mut less, mut more) = (1e-2_f64.ln(), 1e2_f64.ln());
    // During the search large forces reduce the depth below the minimum chip.
    job.process.pass.below_minimum_chip = BelowMinimumChip::Extrapolate;
    for _ in 0..50 {
        let middle = 0.5 * (less + more);
        let coefficient_n = plain.coefficient_n * middle.exp();
        job.process.force = ForceLaw::Power(PowerLaw { coefficient_n, ..plain });
        let first = first_error_mm(job, input)?;
        (less, more) = if first < input.uncompensated_mm[0] { (middle, more) } else { (less, middle) };
    }
    Ok(less.exp())
}

fn workpiece(job: &Job) -> Result<TurningProcess, ReproductionError> {
    let stock = Stock { diameter_mm: job.part.stock_diameter_mm, length_mm: job.part.length_mm };
    Ok(TurningProcess::new(&job.process, stock, &BaseForm::default(), job.seed)?)
}

fn first_error_mm(job: &Job, input: &PidInput) -> Result<f64, ReproductionError> {
    let mut process = workpiece(job)?;
    let plan = job.loop_job().pass_plan(1, DiameterOffset::zero(job.part.station_z_mm().len()));
    process.cut_profile(&plan)?;
    let step = job.part.length_mm / (process.diameter_mm().len() - 1) as f64;
    Ok(linear(process.diameter_mm(), input.position_mm.min(job.part.length_mm) / step) - plan.nominal_mm)
}

/// True errors over z after every pass, (mm, mm of diameter).
fn profiles(job: &Job, input: &PidInput, compensation: Compensation) -> Result<Profiles, ReproductionError> {
    let mut process = workpiece(job)?;
    let stations = job.part.station_z_mm();
    let settings = PidSettings {
        kp: input.kp,
        ki: input.ki,
        kd: input.kd,
        first_pass: FirstPass::Proportional,
        ..PidSettings::default()
    };
    let mut pid = Pid::new(&settings, stations.len());
    let mut offset = DiameterOffset::zero(stations.len());
    let mut profiles = Profiles::new();
    for pass in 1..=PASSES as u32 {
        let plan = job.loop_job().pass_plan(pass, offset.clone());
        process.cut_profile(&plan)?;
        let step = job.part.length_mm / (process.diameter_mm().len() - 1) as f64;
        let error = |z: f64| linear(process.diameter_mm(), z / step) - plan.nominal_mm;
        let nodes = process.diameter_mm().iter().enumerate();
        profiles.push(nodes.map(|(i, d)| (step * i as f64, d - plan.nominal_mm)).collect());
        let output = pid.step(&stations.iter().map(|z| error(*z)).collect::<Vec<f64>>());
        for (o, u) in offset.o_mm.iter_mut().zip(output) {
            match compensation {
                Compensation::None => {}
                Compensation::Pid(OffsetForm::Absolute) => *o = u,
                Compensation::Pid(OffsetForm::Accumulated) => *o += u,
            }
        }
    }
    Ok(profiles)
}

fn linear(values: &[f64], position: f64) -> f64 {
    let lower = (position.max(0.0) as usize).min(values.len() - 2);
    values[lower] + (position - lower as f64) * (values[lower + 1] - values[lower])
}
