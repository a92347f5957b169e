//! Midlines of a drawn machine through frames: a part is cut on it, its shadow rendered with the
//! head where the machine carries it, and measured by the gauge as `measure --midline` does.

use crate::cell::{SimulatedCell, TurningCell as _};
use crate::gauge::calibration::Conditions;
use crate::gauge::{Calibration, Gauge};
use crate::identification::midline_file::MidlineRows;
use crate::identification::reading_set::ReadingPlan;
use crate::job::{Job, RunMachine};
use crate::machine::MachineSettings;
use crate::plan::{DiameterOffset, ScanPlan};
use crate::render::{BackendChoice, Renderer};
use crate::setting::SettingError;

fn refuse(why: &impl std::fmt::Display) -> SettingError {
    SettingError::at("--frames", why.to_string())
}

/// Frames of every place of a plan at the angles of a job, one sweep forward, as the text of a file
/// of readings. The gauge is given the nominal scale of the job's camera and nothing of the
/// machine.
///
/// # Errors
/// A job that cannot run on the machine, a frame without a midline.
pub(super) fn midline_text(
    job: &Job,
    truth: &MachineSettings,
    temperature_c: f64,
    plan: &ReadingPlan,
    seed: u64,
) -> Result<String, SettingError> {
    let mut job = job.clone();
    job.seed = seed;
    job.machine = Some(RunMachine {
        stated: Some(truth.clone()),
        temperature_c: Some(temperature_c),
        ..RunMachine::default()
    });
    let order = job.checked_loop()?;
    let renderer = Renderer::new(BackendChoice::Cpu).map_err(|e| refuse(&e))?;
    let mut cell = SimulatedCell::new(&job, &renderer).map_err(|e| refuse(&e))?;
    let stations = order.station_z_mm().len();
    cell.cut(&order.pass_plan(1, DiameterOffset::zero(stations))).map_err(|e| refuse(&e))?;
    let gauge = Gauge::new(order.gauge.clone()).map_err(|e| refuse(&e))?;
    let calibration = Calibration::from_scale(1e3 * order.field.mm_per_px);
    let mut frames = cell.scan(&scan_plan(plan, job.scan.angles)).map_err(|e| refuse(&e))?;
    let mut rows = MidlineRows::default();
    while let Some(frame) = frames.next_frame().map_err(|e| refuse(&e))? {
        let at = frame.meta.z_mm;
        let found = gauge.measure(&frame.view(), &calibration, &Conditions::default());
        let midline = found
            .map_err(|e| refuse(&format!("the frame at z = {at} mm: {e}")))?
            .midline
            .ok_or_else(|| {
                refuse(&format!(
                    "the frame at z = {at} mm has no midline: its field leaves the part of the job"
                ))
            })?;
        rows.add(&frame.meta, Some(midline));
    }
    rows.text().map_err(|e| refuse(&e))
}

fn scan_plan(plan: &ReadingPlan, angles: usize) -> ScanPlan {
    let step = (plan.to_mm - plan.from_mm) / (plan.positions - 1) as f64;
    ScanPlan {
        field_z_mm: (0..plan.positions).map(|k| plan.from_mm + step * k as f64).collect(),
        angle_deg: (0..angles).map(|k| 360.0 * k as f64 / angles as f64).collect(),
    }
}
