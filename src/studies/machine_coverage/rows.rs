//! Shares of figures within their uncertainty, over all machines.

use serde::Serialize;

use super::figures::Off;

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

/// Standard deviation of the mean of the machines' own shares, per cent: the figures of one machine
/// are tied.
pub(super) fn scatter_percent(machines: &[Vec<Off>]) -> f64 {
    let share = |offs: &Vec<Off>| 1e2 * within(offs) as f64 / offs.len().max(1) as f64;
    let count = machines.len() as f64;
    let mean = machines.iter().map(share).sum::<f64>() / count;
    let square = machines.iter().map(|offs| (share(offs) - mean).powi(2)).sum::<f64>();
    if machines.len() < 2 { 1e2 } else { (square / (count - 1.0) / count).sqrt() }
}

fn within<'a>(offs: impl IntoIterator<Item = &'a Off>) -> usize {
    offs.into_iter().filter(|off| off.off_um.abs() <= 2.0 * off.u_um).count()
}

/// The share of values of one figure.
pub(super) fn row(figure: &str, values: &[&Off]) -> CoverageRow {
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
