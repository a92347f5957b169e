//! Fig. 11 on the physical plant: the turning process, its true diameters in the controller's place of measurement.

use super::ReproductionError;
use super::inputs::PidInput;
use crate::control::{FirstPass, OffsetForm, Pid, PidSettings};
use crate::job::Job;
use crate::plan::DiameterOffset;
use crate::process::{BaseForm, Stock, TurningProcess};
use crate::studies::reproduction::{Row, Verdict};

/// The main job: 45 steel, Ø25 at the end, v 80, f 0.1, a_p 0.25, as in the paper's experiment.
pub(super) const JOB: &str = include_str!("../../../configs/slender_shaft.toml");

pub(super) fn job() -> Result<Job, ReproductionError> {
    toml::from_str(JOB).map_err(|e| ReproductionError::Job(e.to_string()))
}

/// How offsets follow from the controller's output; none without control.
#[derive(Clone, Copy, PartialEq)]
enum Compensation {
    None,
    Pid(OffsetForm),
}

pub(super) fn rows(input: &PidInput) -> Result<Vec<Row>, ReproductionError> {
    let job = job()?;
    let without = errors_mm(&job, input, Compensation::None)?;
    let absolute = errors_mm(&job, input, Compensation::Pid(OffsetForm::Absolute))?;
    let accumulated = errors_mm(&job, input, Compensation::Pid(OffsetForm::Accumulated))?;
    let mut rows = Vec::new();
    for (k, error) in without.iter().enumerate() {
        rows.push(Row::judged(
            (&format!("fig11.physical.none.pass{}", k + 1), &format!("error after pass {}, no control", k + 1), "mm"),
            Some(input.uncompensated_mm[k]),
            *error,
            Verdict::Contradiction,
            format!(
                "a shaft of {} mm between chuck and tailstock; the paper gives neither length nor supports of the one it cut",
                job.part.length_mm
            ),
        ));
    }
    let growth = |errors: &[f64]| errors[3] / errors[0];
    rows.push(Row::judged(
        ("fig11.physical.growth", "fourth over first error without control", ""),
        Some(growth(&input.uncompensated_mm)),
        growth(&without),
        Verdict::Contradiction,
        "error copying has a factor below 1 and cannot let errors grow; a thinning shaft does, but not that much",
    ));
    for (name, errors, reason) in [
        ("absolute", &absolute, "offsets absolute as printed in eq. 18: the loop oscillates"),
        ("accumulated", &accumulated, "offsets accumulated, K_i restored"),
    ] {
        let ours = errors[3].abs() / errors[0];
        let paper = growth(&input.compensated_mm);
        let verdict = if ours <= 2.0 * paper { Verdict::Consistent } else { Verdict::Contradiction };
        let id = format!("fig11.physical.{name}");
        rows.push(Row::judged(
            (&id, "fourth over first error, compensated", ""),
            Some(paper),
            ours,
            verdict,
            reason,
        ));
    }
    Ok(rows)
}

/// True errors at the paper's position after every pass, mm of diameter. The last pass aims at its nominal here.
fn errors_mm(job: &Job, input: &PidInput, compensation: Compensation) -> Result<Vec<f64>, ReproductionError> {
    let stock = Stock { diameter_mm: job.part.stock_diameter_mm, length_mm: job.part.length_mm };
    let mut process = TurningProcess::new(&job.process, stock, &BaseForm::default(), job.seed)?;
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
