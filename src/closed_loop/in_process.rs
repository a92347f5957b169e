//! A pass that is measured while it is cut, and whose stations ahead of the tool are corrected by
//! those behind it.

use super::error::LoopError;
use super::evidence::AfterCut;
use super::scan::{Measured, Progress};
use super::{ClosedLoop, CutPass};
use crate::cell::FollowedCut;
use crate::control::WithinPass;
use crate::gauge::SettledStream;
use crate::job::LoopJob;
use crate::nc;
use crate::plan::{DiameterOffset, FeedDirection, PassPlan};

impl ClosedLoop<'_> {
    /// Cuts a pass with the gauge behind the tool; the machine's state is that at the start of the
    /// cut. Fields that the gauge does not reach during the cut are scanned after it, with the tool
    /// clear.
    pub(super) fn cut_and_follow(
        &mut self,
        plan: &PassPlan,
        progress: Progress<'_>,
    ) -> Result<CutPass, LoopError> {
        let follow = self.job.follow_plan(plan.pass);
        let frames = follow.all_frames();
        let of = self.cell.in_machine();
        let control = &self.job.control;
        let mut within = control
            .within_pass
            .map(|settings| WithinPass::begin(settings, control.plant_gain, &plan.offset.o_mm));
        let stream = match within {
            // A correction ahead of the tool cannot wait.
            Some(_) => SettledStream::at_once(self.gauge.stream()),
            None => SettledStream::new(self.gauge.stream()),
        };
        let mut measured = Measured::new(&self.job, frames, self.of_part.camera()?, stream);
        let mut cut = self.cell.cut_followed(plan, &follow)?;
        let after_cut = AfterCut::begun(of, cut.now_ns());
        let mut notes = Vec::new();
        while let Some(frame) = measured.wait(cut.as_mut())? {
            if let Some(spent) = measured.take(frame) {
                cut.recycle(spent);
            }
            progress(measured.tally.frames, frames);
            let burst_done = measured.tally.frames.is_multiple_of(follow.burst.max(1));
            if let Some(within) = within.as_mut().filter(|_| burst_done) {
                notes.extend(correct_ahead(&self.job, within, plan, &measured, cut.as_mut())?);
            }
        }
        cut.finish()?;
        measured.scan(self.cell.as_mut(), &follow.rest, frames, progress)?;
        let offset = within.map_or_else(|| plan.offset.clone(), |w| DiameterOffset { o_mm: w.applied_mm() });
        let scan = measured.finish(plan.pass);
        Ok(CutPass { plan: PassPlan { offset, ..plan.clone() }, scan, after_cut, notes })
    }
}

/// Corrects the stations ahead of the tool by the new readings; where the machine refuses, the pass
/// stays as it was.
fn correct_ahead(
    job: &LoopJob,
    within: &mut WithinPass,
    plan: &PassPlan,
    measured: &Measured<'_>,
    cut: &mut dyn FollowedCut,
) -> Result<Option<String>, LoopError> {
    let tool_z_mm = cut.tool_z_mm();
    // The command is linear between stations' middles: a changed one moves the path up to its
    // neighbour.
    let room = job.part.station_mm;
    let ahead = |z_mm: f64| match job.feed_direction {
        FeedDirection::TowardsChuck => z_mm + room < tool_z_mm,
        FeedDirection::TowardsTailstock => z_mm - room > tool_z_mm,
    };
    let kept = within.clone();
    let read = measured.sums.averager.finish(plan.pass);
    let Some(offsets) = within.decide(plan.nominal_mm, &read, ahead) else { return Ok(None) };
    let asked = PassPlan { offset: DiameterOffset { o_mm: offsets }, ..plan.clone() };
    let refused = match rounded(job, &asked) {
        Ok(in_force) => {
            within.put_in_force(&in_force.o_mm, &plan.station_z_mm, ahead);
            cut.command(&DiameterOffset { o_mm: within.applied_mm() }).err().map(|e| e.to_string())
        }
        Err(refused) => Some(format!("program: {refused}")),
    };
    Ok(refused.map(|why| {
        *within = kept;
        format!("within the pass, tool at {tool_z_mm:.1} mm: not corrected: {why}")
    }))
}

/// The offsets of a plan as the machine's program makes them, knots and increments as between
/// passes; unchanged without a machine.
fn rounded(job: &LoopJob, plan: &PassPlan) -> Result<DiameterOffset, nc::NcError> {
    let Some(machine) = &job.nc else { return Ok(plan.offset.clone()) };
    Ok(nc::Path::new(plan, &machine.machine, machine.dialect)?.in_force)
}
