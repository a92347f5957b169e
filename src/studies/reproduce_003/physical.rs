//! Fig. 11 on the physical plant: the turning process, its true diameters in the controller's place of measurement.
//!
//! The paper gives neither length nor supports of the shaft it cut. The main job's shaft (Ø25 at the end, the paper's
//! cutting data) is taken with a radial force scaled so that its first error is the paper's: that keeps the shape, small
//! at both ends and large in the middle, which a softer tailstock would not.

use super::ReproductionError;
use super::inputs::PidInput;
use crate::control::{FirstPass, OffsetForm, Pid, PidSettings};
use crate::job::Job;
use crate::plan::DiameterOffset;
use crate::process::{BaseForm, BelowMinimumChip, ForceLaw, PowerLaw, Stock, TurningProcess};
use crate::studies::reproduction::{Row, Verdict};

/// The main job: 45 steel, Ø25 at the end, v 80, f 0.1, a_p 0.25, as in the paper's experiment.
pub(super) const JOB: &str = include_str!("../../../configs/slender_shaft.toml");

pub(super) fn job() -> Result<Job, ReproductionError> {
    let mut job: Job = toml::from_str(JOB).map_err(|e| ReproductionError::Job(e.to_string()))?;
    // The paper's model has the radial force alone, on a straight shaft.
    job.process.bending = crate::process::BendingSettings::default();
    job.shaft.bow = crate::shaft::Bow::default();
    Ok(job)
}

/// How offsets follow from the controller's output; none without control.
#[derive(Clone, Copy, PartialEq)]
enum Compensation {
    None,
    Pid(OffsetForm),
}

pub(super) fn rows(input: &PidInput) -> Result<Vec<Row>, ReproductionError> {
    let mut job = job()?;
    job.part.aim_mm = 0.0;
    let factor = identified_force(&mut job, input)?;
    let without = errors_mm(&job, input, Compensation::None)?;
    let absolute = errors_mm(&job, input, Compensation::Pid(OffsetForm::Absolute))?;
    let accumulated = errors_mm(&job, input, Compensation::Pid(OffsetForm::Accumulated))?;
    let assumed = format!("a shaft of {} mm, {factor:.2} times Table 1's force", job.part.length_mm);
    let mut rows = vec![Row::judged(
        ("fig11.physical.force", "radial force over Table 1's at which the first error is the paper's", ""),
        None,
        factor,
        Verdict::Consistent,
        "the paper gives neither length nor supports of the shaft it cut: identified from its first error",
    )];
    for (name, paper, errors) in [
        ("none", &input.uncompensated_mm, &without),
        ("absolute", &input.compensated_mm, &absolute),
        ("accumulated", &input.compensated_mm, &accumulated),
    ] {
        for (k, error) in errors.iter().enumerate() {
            let id = format!("fig11.physical.{name}.pass{}", k + 1);
            let quantity = format!("error after pass {}, physical plant, offsets {name}", k + 1);
            // With control, an error below the paper's agrees as well.
            let near = (error - paper[k]).abs() <= 0.15 * errors[0];
            let smaller = name != "none" && error.abs() - paper[k] <= 0.15 * errors[0];
            let verdict = if smaller || near { Verdict::Consistent } else { Verdict::Contradiction };
            rows.push(Row::judged((&id, &quantity, "mm"), Some(paper[k]), *error, verdict, &*assumed));
        }
    }
    rows.push(Row::judged(
        ("fig11.physical.growth", "fourth over first error without control", ""),
        Some(input.uncompensated_mm[3] / input.uncompensated_mm[0]),
        without[3] / without[0],
        Verdict::Contradiction,
        "copied errors level off, their factor being below 1; the thinning shaft adds to them, but not that much",
    ));
    for (name, errors, reason) in [
        (
            "absolute",
            &absolute,
            "offsets absolute as printed in eq. 18: the correction is lost in every other pass",
        ),
        ("accumulated", &accumulated, "offsets accumulated, K_i restored: the form that works"),
    ] {
        let worst =
            |errors: &[f64]| errors[1..].iter().fold(0.0, |m: f64, e| m.max(e.abs())) / errors[0].abs();
        let (ours, paper) = (worst(errors), worst(&input.compensated_mm));
        let verdict = if ours <= paper { Verdict::Consistent } else { Verdict::Contradiction };
        let id = format!("fig11.physical.{name}.worst");
        rows.push(Row::judged(
            (&id, "largest later error over the first, compensated", ""),
            Some(paper),
            ours,
            verdict,
            reason,
        ));
    }
    Ok(rows)
}

/// Scales the force law so that the first error at the paper's position is the paper's, by bisection over the logarithm
/// of the factor (more force makes a larger error). An end of the search where the paper's error is out of reach.
fn identified_force(job: &mut Job, input: &PidInput) -> Result<f64, ReproductionError> {
    let plain = if let ForceLaw::Power(law) = &job.process.force { *law } else { PowerLaw::default() };
    let (mut less, mut more) = (1e-2_f64.ln(), 1e2_f64.ln());
    // So much force leaves less than the minimum chip on the way to the answer.
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
    let plan = job.pass_plan(1, DiameterOffset::zero(job.part.station_z_mm().len()));
    process.cut_profile(&plan)?;
    let step = job.part.length_mm / (process.diameter_mm().len() - 1) as f64;
    Ok(linear(process.diameter_mm(), input.position_mm.min(job.part.length_mm) / step) - plan.nominal_mm)
}

/// True errors at the paper's position after every pass, mm of diameter.
fn errors_mm(job: &Job, input: &PidInput, compensation: Compensation) -> Result<Vec<f64>, ReproductionError> {
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
    let mut errors = Vec::new();
    for pass in 1..=4 {
        let plan = job.pass_plan(pass, offset.clone());
        process.cut_profile(&plan)?;
        let step = job.part.length_mm / (process.diameter_mm().len() - 1) as f64;
        let error = |z: f64| linear(process.diameter_mm(), z / step) - plan.nominal_mm;
        errors.push(error(input.position_mm.min(job.part.length_mm)));
        let output = pid.step(&stations.iter().map(|z| error(*z)).collect::<Vec<f64>>());
        for (o, u) in offset.o_mm.iter_mut().zip(output) {
            match compensation {
                Compensation::None => {}
                Compensation::Pid(OffsetForm::Absolute) => *o = u,
                Compensation::Pid(OffsetForm::Accumulated) => *o += u,
            }
        }
    }
    Ok(errors)
}

fn linear(values: &[f64], position: f64) -> f64 {
    let lower = (position.max(0.0) as usize).min(values.len() - 2);
    values[lower] + (position - lower as f64) * (values[lower + 1] - values[lower])
}
