//! The interface of a controller.

use super::context::{PartStart, PassContext};
use crate::plan::{Decision, DiameterOffset, PassPlan};
use crate::profile::DiameterProfile;

/// A pass-to-pass controller. Stateful: it keeps its own sums, last errors and last released
/// offsets.
pub trait Controller {
    /// Name as on the command line: none, pid, lsq, …
    fn name(&self) -> &str;

    /// A new part is clamped: forgets the last one's passes and gives the offsets of the first
    /// pass, zero unless earlier parts were learnt from (`[control.parts]`).
    fn begin_part(&mut self, _start: &PartStart<'_>, stations: usize) -> DiameterOffset {
        DiameterOffset::zero(stations)
    }

    /// Decides the offsets of the next pass from the pass just measured. `plan` is what was
    /// commanded in that pass (its `nominal_mm` is the r of the error e = D - r; its `offset` the
    /// offsets in force). What is missing from `context` cannot be guarded.
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

    /// As [`Self::decide_in`], knowing nothing but the plan and the measurement.
    fn decide(&mut self, plan: &PassPlan, measured: &DiameterProfile) -> Decision {
        self.decide_in(plan, measured, &PassContext::default())
    }

    /// Remarks on the last decision that belong in the log, such as stations that were
    /// interpolated.
    fn notes(&self) -> &[String] {
        &[]
    }

    /// After a refusal: why the next pass is not to be cut with the offsets held, until someone has
    /// looked.
    fn alarm(&self) -> Option<&str> {
        None
    }
}
