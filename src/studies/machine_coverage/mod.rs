//! Whether the stated uncertainty of what is compensated holds: machines of a class are drawn,
//! their readings simulated as a plan has them, their errors identified, and every compensated
//! figure is compared with the truth.
//!
//! In: a plan of readings as `calibrate machine` takes it, a number of machines, a seed, and the
//! job of a camera whose frames the midlines are read in, where `frames` asks for it. Out:
//! [`MachineCoverage`], the share of figures within U = 2u of the truth, figure by figure. `drawn`
//! draws a machine, `frames` are its midlines through frames, `figures` are what is compensated,
//! `plan` numbers the machines. The identification gets the text of the readings alone. A machine
//! has the errors that the plan seeks and no others: what is not sought is in no uncertainty, and
//! is named in `machine.json`.

mod drawn;
mod figures;
mod frames;
mod plan;

use serde::Serialize;

use self::figures::Off;
use super::sharding::{SceneStudy, outcomes};
use crate::setting::SettingError;

pub(crate) use self::plan::MachineCoveragePlan;

/// Shares that a coverage of 95 % may have, per cent.
const WANTED_PERCENT: [f64; 2] = [94.0, 96.0];

/// A compensated figure over all machines.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct CoverageRow {
    /// What was compensated.
    pub figure: String,
    /// Values of it: machines times places.
    pub values: usize,
    /// Share of the values within U = 2u of the truth, per cent.
    pub within_percent: f64,
    /// Deviations from the truth, rms, µm.
    pub rms_off_um: f64,
    /// Their standard uncertainties, rms, µm.
    pub rms_u_um: f64,
    /// What would be left without compensation, rms, µm.
    pub rms_uncompensated_um: f64,
}

/// The figures over all machines.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct MachineCoverage {
    /// Machines drawn.
    pub machines: u32,
    /// Seed of the draws.
    pub seed: u64,
    /// Figure by figure.
    pub figures: Vec<CoverageRow>,
    /// All of them together.
    pub together: CoverageRow,
    /// Standard deviation of the share of all figures, from that of the machines, per cent.
    pub scatter_percent: f64,
    /// Whether midlines were read in rendered frames.
    pub through_frames: bool,
}

impl MachineCoverage {
    /// Whether the share of all figures together lies within 94 to 96 %; through frames, of which
    /// few machines are affordable, twice its standard deviation further.
    pub(crate) fn holds(&self) -> bool {
        let slack = if self.through_frames { 2.0 * self.scatter_percent } else { 0.0 };
        let [least, most] = [WANTED_PERCENT[0] - slack, WANTED_PERCENT[1] + slack];
        (least..=most).contains(&self.together.within_percent)
    }
}

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

/// Standard deviation of the mean of the machines' own shares, per cent: the figures of one machine
/// are tied.
fn scatter_percent(machines: &[Vec<Off>]) -> f64 {
    let share = |offs: &Vec<Off>| 1e2 * within(offs) as f64 / offs.len().max(1) as f64;
    let count = machines.len() as f64;
    let mean = machines.iter().map(share).sum::<f64>() / count;
    let square = machines.iter().map(|offs| (share(offs) - mean).powi(2)).sum::<f64>();
    if machines.len() < 2 { 1e2 } else { (square / (count - 1.0) / count).sqrt() }
}

fn within<'a>(offs: impl IntoIterator<Item = &'a Off>) -> usize {
    offs.into_iter().filter(|off| off.off_um.abs() <= 2.0 * off.u_um).count()
}

fn row(figure: &str, values: &[&Off]) -> CoverageRow {
    let count = values.len();
    let rms = |of: fn(&Off) -> f64| {
        (values.iter().map(|v| of(v).powi(2)).sum::<f64>() / count.max(1) as f64).sqrt()
    };
    let within = within(values.iter().copied());
    CoverageRow {
        figure: figure.to_owned(),
        values: count,
        within_percent: 1e2 * within as f64 / count.max(1) as f64,
        rms_off_um: rms(|v| v.off_um),
        rms_u_um: rms(|v| v.u_um),
        rms_uncompensated_um: rms(|v| v.uncompensated_um),
    }
}
