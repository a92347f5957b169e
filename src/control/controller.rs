//! The interface of a controller.

use super::context::{PartStart, PassContext};
use super::external::ProgramError;
use crate::plan::{Decision, DiameterOffset, PassPlan};
use crate::profile::DiameterProfile;

/// A pass-to-pass controller. Stateful: it keeps its own sums, last errors and last released
/// offsets.
pub trait Controller {
    /// Name as on the command line: none, pid, lsq, …
    fn name(&self) -> &str;

    /// A new part is clamped: discards the passes of the last one and returns the offsets of the
    /// first pass, zero unless offsets are carried over from earlier parts (`[control.parts]`).
    fn begin_part(&mut self, _start: &PartStart<'_>, stations: usize) -> DiameterOffset {
        DiameterOffset::zero(stations)
    }

    /// Decides the offsets of the next pass from the pass just measured. `plan` is the command of
    /// that pass (its `nominal_mm` is the r of the error e = D - r; its `offset` the offsets in
    /// force). Guards whose input is missing from `context` do not run.
    fn decide_in(
        &mut self,
        plan: &PassPlan,
        measured: &DiameterProfile,
        context: &PassContext<'_>,
    ) -> Decision;

    /// Whether a second scan of this pass is needed before [`Self::decide_in`]: a step so large
    /// that two must agree.
    fn needs_repeat(
        &self,
        _plan: &PassPlan,
        _measured: &DiameterProfile,
        _context: &PassContext<'_>,
    ) -> bool {
        false
    }

    /// As [`Self::decide_in`], from the plan and the measurement alone.
    fn decide(&mut self, plan: &PassPlan, measured: &DiameterProfile) -> Decision {
        self.decide_in(plan, measured, &PassContext::default())
    }

    /// Remarks on the last decision that belong in the log, such as stations that were
    /// interpolated.
    fn notes(&self) -> &[String] {
        &[]
    }

    /// After a refusal: why the next pass must not be cut with the held offsets before an
    /// inspection.
    fn alarm(&self) -> Option<&str> {
        None
    }

    /// Why this controller cannot decide any more: the program behind it failed. The decisions from
    /// then on hold.
    fn failure(&self) -> Option<&ProgramError> {
        None
    }
}
