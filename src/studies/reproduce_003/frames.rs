//! Fig. 11 on the physical plant through frames: every error is measured on rendered shadowgraphs.

use super::curves::{Curves, of_passes};
use super::error::ReproductionError;
use super::inputs::{Inputs, PidInput};
use super::physical::{job, shape, worst};
use crate::cell::SimulatedCell;
use crate::closed_loop::{ClosedLoop, LoopError};
use crate::control::ControllerName;
use crate::job::Job;
use crate::render::Renderer;
use crate::studies::reproduction::Row;

/// One run: measured errors of every pass at the paper's position, mm.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FrameRun {
    /// Measured errors.
    pub error_mm: Vec<f64>,
    /// Measured errors of every pass over z, (mm, mm).
    pub profiles: Vec<Vec<(f64, f64)>>,
    /// Largest |measured - true| over stations and passes, mm.
    pub worst_reading_mm: f64,
}

/// Controllers that are run.
pub(super) const RUNS: [ControllerName; 2] = [ControllerName::None, ControllerName::Pid];

pub(super) fn rows(
    inputs: &Inputs,
    renderer: &Renderer,
    curves: &mut Curves,
    done: &dyn Fn(),
) -> Result<Vec<Row>, ReproductionError> {
    let input = &inputs.pid;
    let mut job = job(inputs)?;
    job.scan.angles = 2;
    let of = |controller| run(&job, controller, input, renderer, done);
    let (without, with) = (of(RUNS[0])?, of(RUNS[1])?);
    curves.frames_none = of_passes(&without.profiles, &[], input.position_mm);
    curves.frames_pid = of_passes(&with.profiles, &[], input.position_mm);
    let mut rows = Vec::new();
    for (name, found, reason) in [
        ("none", &without, "Table 1's force, rendered and measured: grows from pass to pass, as the paper's"),
        ("pid", &with, "Table 1's force, rendered and measured, offsets accumulated, K_i restored"),
    ] {
        for (k, error) in found.error_mm.iter().enumerate() {
            let id = format!("fig11.frames.{name}.pass{}", k + 1);
            let quantity = format!("measured error after pass {}, controller {name}", k + 1);
            // Without a number from the paper, which does not describe its shaft.
            rows.push(Row::ours((&id, &quantity, "mm"), *error, reason));
        }
    }
    rows.push(worst(
        "fig11.frames.worst",
        &with.error_mm,
        &input.compensated_mm,
        "how far compensation takes the measured error down",
    ));
    rows.push(shape("fig11.frames.shape", "without control, measured", &without.profiles));
    rows.push(Row::ours(
        ("fig11.frames.reading", "largest measured less true diameter of a station", "mm"),
        without.worst_reading_mm.max(with.worst_reading_mm),
        "the gauge's; two spindle angles a field",
    ));
    Ok(rows)
}

fn run(
    job: &Job,
    controller: ControllerName,
    input: &PidInput,
    renderer: &Renderer,
    done: &dyn Fn(),
) -> Result<FrameRun, ReproductionError> {
    let mut job = job.clone();
    job.control.controller = controller;
    let cell = SimulatedCell::new(&job, renderer).map_err(LoopError::from)?;
    let mut turning = ClosedLoop::start(job.checked_loop().map_err(LoopError::from)?, Box::new(cell), None)?;
    let mut found = FrameRun { error_mm: Vec::new(), profiles: Vec::new(), worst_reading_mm: 0.0 };
    while turning.next_pass().is_some() {
        let pass = turning.run_pass(&mut |_, _| {})?;
        done();
        let measured =
            pass.profile.stations.iter().filter_map(|station| {
                Some((station.z_mm, station.reading.value()?.d_mm - pass.plan.nominal_mm))
            });
        let profile: Vec<(f64, f64)> = measured.collect();
        let away = |z_mm: f64| (z_mm - input.position_mm).abs();
        let nearest = profile.iter().min_by(|a, b| away(a.0).total_cmp(&away(b.0)));
        found.error_mm.push(nearest.map_or(f64::NAN, |nearest| nearest.1));
        found.profiles.push(profile);
        for (station, truth) in pass.profile.stations.iter().zip(pass.truth_mm.iter().flatten()) {
            if let Some(d) = station.reading.value() {
                found.worst_reading_mm = found.worst_reading_mm.max((d.d_mm - truth).abs());
            }
        }
    }
    Ok(found)
}
