//! Is the loop from pass to pass stable, and by what margin?
//!
//! Plant, per station or shape, errors and offsets in mm of diameter, w everything that does not
//! depend on the loop:
//!
//! ```text
//! e(k+1) = α e(k) − g o(k+1) + w(k)
//! constant disturbance  α = 0        g: change of diameter over change of command
//! error copying         α = 1 − g    a share 1 − g of the error before the cut survives it
//! error transfer        α given      paper 003, Fig. 11, read as e(k+1) = 1.3566 e(k) − .704 u(k)
//! ```
//!
//! Controller o(k+1) = N(q)/D(q) e(k) with q the forward shift. The closed loop's poles are the
//! roots of (q − α) D(q) + g N(q). Stable: every pole inside the unit circle (checked by
//! eigenvalues of the companion matrix and, independently, by Jury's table).

mod iteration;
mod loops;
mod polynomial;

pub(crate) use iteration::{IterationReport, iteration, whittaker};
pub(crate) use loops::{
    Plant, Transfer, double_ewma_transfer, integral_transfer, model_transfer, pid_transfer,
};
#[cfg(test)]
pub(crate) use polynomial::Polynomial;

/// Range of plant gains that is searched for the limits.
const GAIN_SCAN: std::ops::RangeInclusive<f64> = 1e-4..=4.0;
/// Steps of the scan; a stable window narrower than 1e-3 of gain may be missed.
const GAIN_STEPS: usize = 4000;
/// Limits are bisected to this width of gain.
const GAIN_RESOLUTION: f64 = 1e-10;
/// Passes over which the transient is followed.
const TRANSIENT_PASSES: usize = 200;

/// Stability of a closed loop.
#[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub(crate) struct StabilityReport {
    /// Controller and form.
    pub controller: String,
    /// The plant judged.
    pub plant: String,
    /// Plant gain g.
    pub plant_gain: f64,
    /// Poles of the closed loop, (real, imaginary), largest modulus first.
    pub poles: Vec<(f64, f64)>,
    /// Largest pole modulus.
    pub spectral_radius: f64,
    /// All poles inside the unit circle.
    pub stable: bool,
    /// Jury's table agrees that it is stable.
    pub jury_stable: bool,
    /// Ranges of g in which the loop is stable, within 0 to 4.
    pub stable_gains: Vec<(f64, f64)>,
    /// Upper limit of g over g (above 1: room for a plant that reacts more), where g lies in a
    /// stable range.
    pub gain_margin: Option<f64>,
    /// Largest |e(k)|, k ≥ 2, under a constant disturbance that makes a unit error at pass 1: above
    /// 1, errors grow on the way.
    pub peak_error: f64,
    /// Largest norm of the k-th power of the closed loop's companion matrix.
    pub transient_growth: f64,
}

impl StabilityReport {
    /// The stable gains in words.
    pub(crate) fn range_text(&self) -> String {
        if self.stable_gains.is_empty() {
            return "no plant gain".into();
        }
        let ranges: Vec<String> =
            self.stable_gains.iter().map(|(low, high)| format!("{low:.4} < g < {high:.4}")).collect();
        ranges.join(" or ")
    }
}

/// Assesses a controller with a plant of gain g.
pub(crate) fn judge(controller: &str, transfer: &Transfer, plant: Plant, gain: f64) -> StabilityReport {
    let closed = transfer.closed_loop(plant, gain);
    let poles = closed.roots();
    let spectral_radius = poles.first().map_or(0.0, |p| p.0.hypot(p.1));
    let stable_gains = stable_gains(transfer, plant);
    let gain_margin =
        stable_gains.iter().find(|(low, high)| (*low..*high).contains(&gain)).map(|r| r.1 / gain);
    StabilityReport {
        controller: controller.to_owned(),
        plant: plant.describe(),
        plant_gain: gain,
        spectral_radius,
        stable: spectral_radius < 1.0,
        jury_stable: closed.jury_stable(),
        poles,
        stable_gains,
        gain_margin,
        peak_error: transfer.peak_error(plant, gain, TRANSIENT_PASSES),
        transient_growth: closed.transient_growth(TRANSIENT_PASSES),
    }
}

/// Ranges of the plant gain with all poles inside the unit circle, each limit bisected.
pub(crate) fn stable_gains(transfer: &Transfer, plant: Plant) -> Vec<(f64, f64)> {
    let stable = |g: f64| transfer.closed_loop(plant, g).jury_stable();
    let (start, end) = (*GAIN_SCAN.start(), *GAIN_SCAN.end());
    let at = |i: usize| start + (end - start) * i as f64 / GAIN_STEPS as f64;
    let mut ranges = Vec::new();
    let mut entered = stable(start).then_some(0.0);
    for i in 1..=GAIN_STEPS {
        let (before, here) = (at(i - 1), at(i));
        match (entered, stable(here)) {
            (None, true) => entered = Some(bisect(before, here, |g| !stable(g))),
            (Some(low), false) => {
                ranges.push((low, bisect(before, here, stable)));
                entered = None;
            }
            _ => {}
        }
    }
    ranges.extend(entered.map(|low| (low, end)));
    ranges
}

/// Where the predicate turns from true to false.
fn bisect(mut holds: f64, mut fails: f64, predicate: impl Fn(f64) -> bool) -> f64 {
    while fails - holds > GAIN_RESOLUTION {
        let middle = 0.5 * (holds + fails);
        if predicate(middle) { holds = middle } else { fails = middle }
    }
    0.5 * (holds + fails)
}
