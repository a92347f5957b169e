//! The controller of a job on parts instead of passes: part k stands in the place of pass k.
//!
//! Every part was cut from a new blank, in one pass of the same nominal. A trial cut is given to
//! the controller as what it was: a part with a nominal that lies [`TRIAL_MM`] higher, so that what
//! was left on purpose is no error to correct.

use super::state::{OffsetState, PartRead, TRIAL_MM, station_z_mm};
use crate::control::{self, ControlError, ControlSettings, ControllerName, NextPass, PartStart, PassContext};
use crate::job::LoopJob;
use crate::plan::{Decision, DiameterOffset, PassPlan};
use crate::setting::SettingError;

/// What the controller decided on the last part of a history.
pub(super) struct Released {
    pub(super) decision: Decision,
    pub(super) notes: Vec<String>,
    pub(super) alarm: Option<String>,
}

/// The job's control as parts use it: nothing is learnt from part to part beside the loop itself,
/// which runs from part to part.
fn settings(job: &LoopJob) -> Result<ControlSettings, ControlError> {
    let control = job.run_control();
    if control.controller == ControllerName::Model {
        return Err(ControlError::Setting(SettingError::at(
            "control.controller",
            "\"model\" follows the passes of one part (run with source); from part to part take pid, lsq, ewma, dewma or ilc",
        )));
    }
    Ok(ControlSettings { parts: Default::default(), ..control })
}

/// Diameter before pass `pass`, mm: of the pass before, or of the stock.
pub(super) fn before_mm(job: &LoopJob, pass: u32) -> f64 {
    if pass > 1 { job.part.target_mm(pass - 1) } else { job.part.stock_diameter_mm }
}

fn plan_of(job: &LoopJob, state: &OffsetState, part: &PartRead, number: u32) -> PassPlan {
    let left_mm = if part.trial { TRIAL_MM } else { 0.0 };
    let o_mm = part.readings.iter().map(|r| r.offset_mm + left_mm).collect();
    let plan = job.pass_plan(state.pass, DiameterOffset { o_mm });
    PassPlan { pass: number, nominal_mm: plan.nominal_mm + left_mm, ..plan }
}

/// Gives the controller the state's history, part after part; its decision on the last one.
///
/// # Errors
/// A controller that cannot be built, or that follows the passes of one part.
pub(super) fn release(job: &LoopJob, state: &OffsetState) -> Result<Option<Released>, ControlError> {
    let z_mm = station_z_mm(job);
    let mut controller = control::build(&settings(job)?, job.layout())?;
    controller.begin_part(&PartStart::default(), z_mm.len());
    let context = PassContext {
        next: Some(NextPass {
            nominal_mm: state.nominal_mm,
            cutting: job.cutting,
            finishing: state.pass as usize == job.part.passes(),
        }),
        blank_mm: Some(before_mm(job, state.pass)),
        ..PassContext::default()
    };
    let mut last = None;
    for (part, number) in state.history.iter().zip(1_u32..) {
        let plan = plan_of(job, state, part, number);
        let decision = controller.decide_in(&plan, &part.profile(number, &z_mm), &context);
        last = Some(Released {
            decision,
            notes: controller.notes().to_vec(),
            alarm: controller.alarm().map(str::to_owned),
        });
    }
    Ok(last)
}

/// Ratio of the observed to the commanded change of the diameter between the last two parts; `None`
/// for a command too small to judge by, or without readings at common stations.
pub(super) fn observed_over_commanded(job: &LoopJob, state: &OffsetState) -> Option<f64> {
    let [.., before, last] = &state.history[..] else { return None };
    let pairs = before.readings.iter().zip(&last.readings);
    let changes: Vec<(f64, f64)> =
        pairs.filter_map(|(a, b)| Some((a.offset_mm - b.offset_mm, b.d_mm? - a.d_mm?))).collect();
    let square: f64 = changes.iter().map(|(commanded, _)| commanded * commanded).sum();
    let product: f64 = changes.iter().map(|(commanded, observed)| commanded * observed).sum();
    let from = job.control.guards.response_from_mm;
    (square > 0.0 && square >= from * from * changes.len() as f64).then(|| product / square)
}
