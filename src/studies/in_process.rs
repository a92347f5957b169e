//! `study in-process`: one job scanned after every pass, and while it is cut, with and without
//! correction within the pass.

use serde::Serialize;

use crate::cell::SimulatedCell;
use crate::closed_loop::{Calibrated, ClosedLoop, LoopError, PassResult};
use crate::control::OnAlarm;
use crate::job::{Job, ScanWhen};
use crate::render::Renderer;

/// One pass under one way of scanning.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct InProcessRow {
    /// `after_pass`, `during_cut` or `during_cut, within_pass`.
    pub way: &'static str,
    /// Pass, from 1.
    pub pass: u32,
    /// Largest true error over the stations, µm.
    pub true_max_um: f64,
    /// Root mean square of the true error, µm.
    pub true_rms_um: f64,
    /// Largest |measured − true|, µm.
    pub reading_max_um: f64,
    /// Mean of measured − true, µm.
    pub reading_mean_um: f64,
    /// Rms of (measured − true)/u.
    pub rms_error_over_u: f64,
    /// Stations measured.
    pub stations: usize,
    /// Frames taken.
    pub frames: usize,
    /// Frames refused.
    pub refused: usize,
    /// Largest radial force, N.
    pub radial_force_n: f64,
    /// Largest radial deflection at the tool, µm.
    pub deflection_um: f64,
}

/// The ways that are compared.
const WAYS: [(&str, ScanWhen, bool); 3] = [
    ("after_pass", ScanWhen::AfterPass, false),
    ("during_cut", ScanWhen::DuringCut, false),
    ("during_cut, within_pass", ScanWhen::DuringCut, true),
];

/// Passes that [`run`] cuts in all.
pub(crate) fn passes_in_all(job: &Job) -> usize {
    WAYS.len() * job.loop_job().passes()
}

/// Checks the job for every way.
///
/// # Errors
/// The first setting that is refused.
pub(crate) fn check(job: &Job) -> Result<(), crate::setting::SettingError> {
    WAYS.iter().try_for_each(|way| {
        let one = variant(job, way);
        one.check()?;
        one.check_coverage()?;
        one.check_control()
    })
}

fn variant(job: &Job, &(_, when, within): &(&str, ScanWhen, bool)) -> Job {
    let mut one = job.clone();
    one.scan.when = when;
    let settings = job.control.within_pass.unwrap_or_default();
    one.control.within_pass = within.then_some(settings);
    // Every pass is cut; an alarm counts as offsets held.
    one.control.guards.on_alarm = OnAlarm::GoOn;
    one
}

/// Turns the job once per way of scanning; the optical setup is calibrated once.
///
/// # Errors
/// Where a job does not fit together, the renderer or the gauge fails.
pub(crate) fn run(
    job: &Job,
    renderer: &Renderer,
    done: &mut dyn FnMut(&InProcessRow),
) -> Result<Vec<InProcessRow>, LoopError> {
    let mut rows = Vec::new();
    let mut calibration: Option<Calibrated> = None;
    for way in &WAYS {
        let one = variant(job, way);
        let cell = SimulatedCell::new(&one, renderer)?;
        let mut turning = ClosedLoop::start(one.checked_loop()?, Box::new(cell), calibration.take())?;
        calibration = Some(turning.calibration().clone());
        while turning.next_pass().is_some() {
            let row = row(way.0, &turning.run_pass(&mut |_, _| {})?);
            done(&row);
            rows.push(row);
        }
    }
    Ok(rows)
}

fn row(way: &'static str, pass: &PassResult) -> InProcessRow {
    let nominal = pass.plan.nominal_mm;
    let truth: Vec<f64> = pass.truth_mm.iter().flatten().copied().collect();
    let stations = pass.profile.stations.iter().zip(&truth);
    let read: Vec<(f64, f64)> =
        stations.filter_map(|(s, t)| s.reading.value().map(|d| (d.d_mm - t, d.u_mm()))).collect();
    let n = read.len().max(1) as f64;
    let rms = |values: &mut dyn Iterator<Item = f64>, n: f64| (values.map(|v| v * v).sum::<f64>() / n).sqrt();
    let largest = |values: &mut dyn Iterator<Item = f64>| values.map(f64::abs).fold(0.0, f64::max);
    let cut = pass.cut.clone().unwrap_or_default();
    InProcessRow {
        way,
        pass: pass.plan.pass,
        true_max_um: 1e3 * largest(&mut truth.iter().map(|t| t - nominal)),
        true_rms_um: 1e3 * rms(&mut truth.iter().map(|t| t - nominal), truth.len().max(1) as f64),
        reading_max_um: 1e3 * largest(&mut read.iter().map(|r| r.0)),
        reading_mean_um: 1e3 * read.iter().map(|r| r.0).sum::<f64>() / n,
        rms_error_over_u: rms(&mut read.iter().map(|(e, u)| e / u), n),
        stations: read.len(),
        frames: pass.frames,
        refused: pass.refused.len(),
        radial_force_n: cut.max_force_n,
        deflection_um: 1e3 * cut.max_deflection_mm,
    }
}
