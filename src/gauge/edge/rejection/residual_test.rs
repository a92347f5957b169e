//! Whether noise explains the residual of a fitted edge; a residual beyond noise that neighbours
//! share adds to their uncertainty.

use crate::gauge::edges::{Edge, EdgeState, RESIDUAL_BLOCK};
use crate::numerics::distributions::chi2_ratio_limit;
use crate::profile::Reason;

/// Fraction of the columns, the best fitting ones, from which the reduced χ² of a frame is taken. A
/// deviation in more than half of the columns may still be contamination; one in four of five
/// columns is the model.
const BEST: f64 = 0.2;
/// Normal quantile of [`BEST`].
const BEST_QUANTILE: f64 = -0.8416;

/// χ² ratio of the best fitting fifth of a line's usable edges over that of noise alone; 1 without
/// any.
pub(crate) fn reduced_chi2(line: &[Edge], freedom: f64, pool: &mut Vec<f32>) -> f64 {
    pool.clear();
    let step = line.len().div_ceil(512).max(1);
    pool.extend(line.iter().step_by(step).filter(|e| e.is_usable()).map(|e| e.chi2));
    if pool.is_empty() {
        return 1.0;
    }
    let fifth = (BEST * pool.len() as f64) as usize;
    let (_, value, _) = pool.select_nth_unstable_by(fifth, f32::total_cmp);
    f64::from(*value) / chi2_ratio_limit(freedom, BEST_QUANTILE)
}

/// Standard deviations by which the mean χ² ratio of a block must exceed 1 to be a systematic
/// residual: a block of a clean frame hardly ever does, and its u remains that of the noise.
const EXCESS_LIMIT: f32 = 5.0;
/// Relative standard uncertainty of the noise variance as estimated from one frame.
const NOISE_KNOWN_TO: f32 = 0.02;

/// Adds the uncertainty of the edge model to the shared uncertainty. Where the mean residual of
/// neighbours exceeds the noise by λ = ν(χ² − 1), the model lacks a component that all of them
/// share (an illumination gradient across the edge, a film of mist). It may have displaced the edge
/// by as much as the residual shows of it: u = u_own·√λ. `left_px` is the uncertainty left by a
/// systematic residual known from the calibration. The result goes to `stated`, px, one value a
/// block.
pub(crate) fn add_model_uncertainty(line: &mut [Edge], freedom: f64, left_px: f64, stated: &mut Vec<f32>) {
    stated.clear();
    for block in line.chunks_mut(RESIDUAL_BLOCK) {
        let (mut sum, mut count, mut own) = (0.0_f32, 0.0_f32, 0.0_f32);
        for edge in block.iter().filter(|e| e.is_usable()) {
            (sum, count, own) = (sum + edge.chi2, count + 1.0, own + edge.u_own_px * edge.u_own_px);
        }
        // √(2/νn): what a mean over n columns scatters by.
        let excess = EXCESS_LIMIT * (2.0 / (freedom as f32 * count.max(1.0))).sqrt().hypot(NOISE_KNOWN_TO);
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

/// Standard uncertainty above which an edge is refused, px: edges on the contour of a cloud or of a
/// chip fit so badly that their model uncertainty reaches pixels, where a faint edge of a part has
/// a fraction of one. Edges with a reason of their own (clipped light, with a factor of √2) may
/// have more.
const UNCERTAIN_PX: f64 = 0.5;
const UNCERTAIN_IMPAIRED_PX: f64 = 2.9;

/// Refuses edges too uncertain to be those of the part.
pub(crate) fn reject_uncertain(line: &mut [Edge]) {
    for edge in line.iter_mut() {
        let limit = if edge.state == EdgeState::Good { UNCERTAIN_PX } else { UNCERTAIN_IMPAIRED_PX };
        if edge.is_usable() && !(edge.u_px() <= limit) {
            edge.state = EdgeState::Gap(Reason::Residual);
        }
    }
}
