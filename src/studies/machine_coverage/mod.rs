//! Whether the stated uncertainty of what is compensated holds: machines of a class are drawn,
//! their readings simulated as a plan has them, their errors identified, and every compensated
//! figure is compared with the truth.
//!
//! In: a plan of readings as `calibrate machine` takes it, a number of machines, a seed, and the
//! job of a camera whose frames the midlines are read in, where `frames` asks for it. Out:
//! [`MachineCoverage`], the share of figures within U = 2u of the truth, figure by figure. `drawn`
//! draws a machine, `frames` are its midlines through frames of the part that `part` compares with
//! what the readings state, `figures` are what is compensated, `plan` numbers the machines, `rows`
//! are the shares. The identification gets the text of the readings alone. A machine has the errors
//! that the plan seeks and no others: what is not sought is in no uncertainty, and is named in
//! `machine.json`.

mod drawn;
mod figures;
mod frames;
mod part;
mod plan;
mod rows;

use super::sharding::{SceneStudy, outcomes};
use crate::setting::SettingError;

pub(crate) use self::plan::MachineCoveragePlan;
pub(crate) use self::rows::{CoverageRow, MachineCoverage};

/// Draws machines, identifies them and compares; `done` is called after each.
///
/// # Errors
/// A config that cannot be right, a set without a plan of its own, readings that do not hold what
/// is sought, frames asked of a plan without a midline, a job that cannot run on the machine.
pub(crate) fn machine_coverage(
    plan: &MachineCoveragePlan,
    done: &(dyn Fn() + Sync),
) -> Result<MachineCoverage, SettingError> {
    plan.bench()?;
    Ok(plan.result(&outcomes(plan, &(), 0..plan.scenes(), done)?))
}
