//! Fig. 11 on the physical plant through frames: every error is measured on rendered shadowgraphs.

use super::ReproductionError;
use super::inputs::PidInput;
use super::physical::job;
use crate::cell::SimulatedCell;
use crate::closed_loop::{ClosedLoop, LoopError};
use crate::control::ControllerName;
use crate::job::Job;
use crate::render::Renderer;
use crate::studies::reproduction::{Row, Verdict};

/// One run: measured errors of every pass at the paper's position, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameRun {
    /// Measured errors.
    pub error_mm: Vec<f64>,
    /// Largest |measured - true| over stations and passes, mm.
    pub worst_reading_mm: f64,
}

pub(super) fn rows(input: &PidInput, renderer: &Renderer) -> Result<Vec<Row>, ReproductionError> {
    let mut job = job()?;
    job.scan.angles = 2;
    job.part.aim_mm = 0.0;
    let without = run(&job, ControllerName::None, input, renderer)?;
    let with = run(&job, ControllerName::Pid, input, renderer)?;
    let mut rows = Vec::new();
    for (name, found, reason) in [
        (
            "none",
            &without,
            "the main job's shaft, rendered and measured: grows from pass to pass, as the paper's",
        ),
        ("pid", &with, "the main job's shaft, rendered and measured, offsets accumulated, K_i restored"),
    ] {
        for (k, error) in found.error_mm.iter().enumerate() {
            let id = format!("fig11.frames.{name}.pass{}", k + 1);
            let quantity = format!("measured error after pass {}, controller {name}", k + 1);
            // Without a number of the paper's: its shaft is not described, and this one is the main job's.
            rows.push(Row::judged((&id, &quantity, "mm"), None, *error, Verdict::Consistent, reason));
        }
    }
    let worst = |errors: &[f64]| errors[1..].iter().fold(0.0, |m: f64, e| m.max(e.abs())) / errors[0].abs();
    let (ours, paper) = (worst(&with.error_mm), worst(&input.compensated_mm));
    rows.push(Row::judged(
        ("fig11.frames.worst", "largest later measured error over the first, compensated", ""),
        Some(paper),
        ours,
        if ours <= paper { Verdict::Consistent } else { Verdict::Contradiction },
        "how far compensation takes the error down",
    ));
    rows.push(Row::judged(
        ("fig11.frames.reading", "largest measured less true diameter of a station", "mm"),
        None,
        without.worst_reading_mm.max(with.worst_reading_mm),
        Verdict::Consistent,
        "the gauge's, not the paper's; two spindle angles a field",
    ));
    Ok(rows)
}

fn run(
    job: &Job,
    controller: ControllerName,
    input: &PidInput,
    renderer: &Renderer,
) -> Result<FrameRun, ReproductionError> {
    let mut job = job.clone();
    job.control.controller = controller;
    let cell = SimulatedCell::new(&job, renderer).map_err(LoopError::from)?;
    let mut turning = ClosedLoop::start(&job, Box::new(cell), None)?;
    let mut found = FrameRun { error_mm: Vec::new(), worst_reading_mm: 0.0 };
    while turning.next_pass().is_some() {
        let pass = turning.run_pass(&mut |_, _| {})?;
        let nearest = pass
            .profile
            .stations
            .iter()
            .filter_map(|station| {
                station.reading.value().map(|d| ((station.z_mm - input.position_mm).abs(), d.d_mm))
            })
            .min_by(|a, b| a.0.total_cmp(&b.0));
        found.error_mm.push(nearest.map_or(f64::NAN, |(_, d)| d - pass.plan.nominal_mm));
        for (station, truth) in pass.profile.stations.iter().zip(pass.truth_mm.iter().flatten()) {
            if let Some(d) = station.reading.value() {
                found.worst_reading_mm = found.worst_reading_mm.max((d.d_mm - truth).abs());
            }
        }
    }
    Ok(found)
}
