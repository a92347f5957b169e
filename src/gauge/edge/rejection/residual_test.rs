//! Whether noise explains the residual of a fitted edge; a residual beyond noise that neighbours
//! share adds to their uncertainty.

use std::sync::OnceLock;

use crate::gauge::edges::{Edge, EdgeState, RESIDUAL_BLOCK};
use crate::gauge::limit::limits;
use crate::numerics::distributions::{chi2_ratio_limit, inverse_tail};
use crate::profile::Reason;

limits! {
    /// When a residual is more than noise.
    ResidualLimits = "residual_test";
    /// Share of the columns, the best fitting ones, from which the reduced χ² of a frame is taken.
    /// A deviation in more than half of the columns may still be contamination; one in four of five
    /// columns is the model.
    best: f64 = 0.2;
    /// χ² ratio of the best fitting fifth below which a frame's noise is not what it was taken for:
    /// where an edge has rings, neighbouring columns and pixels differ by these as well as by
    /// noise. A fifth of forty edges of a hundred pixels each is known to 3 %.
    most_noise: f64 = 0.9;
    /// Standard deviations by which a block's mean χ² ratio must exceed 1 to be a systematic
    /// residual: noise does so in 3·10⁻⁷ of the blocks, whose u stays what the noise states.
    excess: f32 = 5.0;
    /// Relative standard uncertainty of the noise variance that one frame determines: √(2/4096)
    /// from `side.noise_samples` differences.
    noise_known_to: f32 = 0.02;
    /// Standard uncertainty beyond which an edge is none, px: what joins the contour of a cloud or
    /// of a chip fits so badly that the systematic residual stated comes to pixels, where a part's
    /// faint edge has a fraction of one.
    uncertain_px: f64 = 0.5;
    /// The same for edges with a reason of their own for a large u (clipped light, stated with √2):
    /// a window reaches 3 px to its side and more. Tuned: see study limits.
    uncertain_impaired_px: f64 = 2.9;
}

impl ResidualLimits {
    /// Normal quantile of `best` to four digits.
    fn best_quantile(&self) -> f64 {
        static QUANTILE: OnceLock<f64> = OnceLock::new();
        *QUANTILE.get_or_init(|| -(1e4 * inverse_tail(self.best)).round() / 1e4)
    }
}

/// χ² ratio of the best fitting fifth of a line's usable edges over what noise alone would give; 1
/// without any.
pub(crate) fn reduced_chi2(line: &[Edge], freedom: f64, pool: &mut Vec<f32>) -> f64 {
    let limits = ResidualLimits::get();
    pool.clear();
    let step = line.len().div_ceil(512).max(1);
    pool.extend(line.iter().step_by(step).filter(|e| e.is_usable()).map(|e| e.chi2));
    if pool.is_empty() {
        return 1.0;
    }
    let fifth = (limits.best * pool.len() as f64) as usize;
    let (_, value, _) = pool.select_nth_unstable_by(fifth, f32::total_cmp);
    f64::from(*value) / chi2_ratio_limit(freedom, limits.best_quantile())
}

/// Takes the edges' noise for what they leave of the model: `share` of the variance that it was
/// taken for.
pub(crate) fn take_noise_back(line: &mut [Edge], share: f64) {
    for edge in line.iter_mut().filter(|e| e.is_usable()) {
        edge.chi2 /= share as f32;
        edge.u_own_px *= share.sqrt() as f32;
    }
}

/// Adds to the shared uncertainty what a common systematic residual may hide. Where the mean
/// residual of neighbours exceeds the noise by λ = ν(χ² − 1), something that all of them share is
/// not in the model (light that falls off across the edge, a film of mist); as much as the residual
/// shows of it may have moved the edge: u = u_own·√λ. `left_px` is what an expected systematic
/// residual leaves to be stated; what is stated goes to `stated`, one value a block.
pub(crate) fn add_model_uncertainty(line: &mut [Edge], freedom: f64, left_px: f64, stated: &mut Vec<f32>) {
    let limits = ResidualLimits::get();
    stated.clear();
    for block in line.chunks_mut(RESIDUAL_BLOCK) {
        let (mut sum, mut count, mut own) = (0.0_f32, 0.0_f32, 0.0_f32);
        for edge in block.iter().filter(|e| e.is_usable()) {
            (sum, count, own) = (sum + edge.chi2, count + 1.0, own + edge.u_own_px * edge.u_own_px);
        }
        // √(2/νn): what a mean over n columns scatters by.
        let excess =
            limits.excess * (2.0 / (freedom as f32 * count.max(1.0))).sqrt().hypot(limits.noise_known_to);
        let shown = sum > (1.0 + excess) * count;
        let hidden = if shown { freedom as f32 * (sum / count - 1.0) } else { 0.0 };
        let left = left_px as f32;
        stated.push((own / count.max(1.0) * hidden + left * left).sqrt());
        if !(shown || left > 0.0) {
            continue;
        }
        for edge in block.iter_mut() {
            edge.u_shared_px = edge.u_shared_px.hypot(edge.u_own_px * hidden.sqrt()).hypot(left);
        }
    }
}

/// Refuses edges whose χ² exceeds `limit`.
pub(crate) fn refuse_residuals(line: &mut [Edge], limit: f32) {
    for edge in line.iter_mut() {
        if edge.is_usable() && !(edge.chi2 <= limit) {
            edge.state = EdgeState::Gap(Reason::Residual);
        }
    }
}

/// Refuses edges that are known too badly to be the part's.
pub(crate) fn reject_uncertain(line: &mut [Edge]) {
    let limits = ResidualLimits::get();
    for edge in line.iter_mut() {
        let limit =
            if edge.state == EdgeState::Good { limits.uncertain_px } else { limits.uncertain_impaired_px };
        if edge.is_usable() && !(edge.u_px() <= limit) {
            edge.state = EdgeState::Gap(Reason::Residual);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An edge of clipped light may be known to 2 px in a window that reaches 3 px to its side, not
    /// to 4 px; one without such a reason to a third of a pixel, not to 0.7 px.
    #[test]
    fn an_edge_that_is_known_too_badly_is_none() {
        let edge = |u_own_px, state| Edge { row_px: 9.0, u_own_px, u_shared_px: 0.0, chi2: 1.0, state };
        let impaired = EdgeState::Impaired(Reason::Saturated);
        let good = EdgeState::Good;
        let mut line =
            [(2.0, impaired), (4.0, impaired), (0.33, good), (0.7, good)].map(|(u, state)| edge(u, state));
        reject_uncertain(&mut line);
        assert_eq!(line.map(|e| e.is_usable()), [true, false, true, false]);
    }
}
