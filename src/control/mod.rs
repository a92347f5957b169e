//! What to change before the next pass: compensation from measured diameters.

mod error;
mod settings;

pub use error::ControlError;
pub use settings::*;

use crate::plan::{Decision, PassPlan};
use crate::profile::DiameterProfile;

/// A pass-to-pass controller. Stateful: it keeps its own sums, last errors and last released offsets.
pub trait Controller {
    /// Name as on the command line: none, pid, lsq, …
    fn name(&self) -> &str;

    /// Decides the offsets of the next pass from the pass just measured. `plan` is what was commanded in that pass
    /// (its `nominal_mm` is the r of the error e = D - r; its `offset` the offsets in force).
    fn decide(&mut self, plan: &PassPlan, measured: &DiameterProfile) -> Decision;
}
