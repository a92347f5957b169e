//! `nc --state`: the next part of a job by the state that `measure --offsets` keeps.

use std::path::Path;

use super::pass::{Pass, workpiece};
use crate::cli::failure::Failure;
use crate::cli::measure::offsets::read_state;
use crate::job::Job;
use crate::part_offsets::{OffsetState, Stage, TRIAL_MM};
use crate::plan::DiameterOffset;

/// The pass that a state commands, and the number of the part that is cut with it.
pub(super) fn next_part(job: &Job, path: &Path, asked: Option<u32>) -> Result<(Pass, u32), Failure> {
    let in_loop = job.loop_job();
    let state = read_state(path, &in_loop, asked.unwrap_or(in_loop.part.passes() as u32))?;
    let before = state.history.last().or(state.first.as_ref());
    let old = before.map_or_else(
        || DiameterOffset::zero(state.stations.len()),
        |part| DiameterOffset { o_mm: part.readings.iter().map(|r| r.offset_mm).collect() },
    );
    // a trial cut is too large on purpose: no re-measurement judges it
    let finishing = state.pass as usize == in_loop.passes() && state.stage != Stage::Trial;
    let pass = Pass {
        plan: state.plan(&in_loop),
        old,
        piece: workpiece(job, state.pass),
        reason: reason(&state),
        limits_mm: job.part.tolerance.filter(|_| finishing).map(|t| t.limits_mm()),
    };
    Ok((pass, state.measurements + 1))
}

/// Why the next part is cut with these offsets.
fn reason(state: &OffsetState) -> String {
    let held = state.held.as_ref().map_or_else(String::new, |why| format!(", held: {why}"));
    match state.stage {
        Stage::First => format!("first part of this tool, without offsets{held}"),
        Stage::Trial => {
            format!(
                "trial cut, {:.0} um larger: sign and unit of the offset are not proven yet",
                1e3 * TRIAL_MM
            )
        }
        Stage::Released => format!("offsets after measurement {}{held}", state.measurements),
    }
}
