//! What makes a fitted edge a gap: a residual that noise does not explain, or a place that its neighbours do not.

use super::edges::{Edge, EdgeState, MISFIT_BLOCK};
use crate::profile::Reason;

/// Columns whose median stands for the neighbourhood.
const NEIGHBOURS: usize = 32;

/// Quantile of χ²_ν over ν after Wilson and Hilferty; `z` is the normal quantile. Within 1 % for ν ≥ 5.
pub(crate) fn chi2_ratio_limit(freedom: f64, z: f64) -> f64 {
    let h = 2.0 / (9.0 * freedom.max(1.0));
    (1.0 - h + z * h.sqrt()).powi(3)
}

/// Normal quantile of an upper tail probability (Abramowitz and Stegun 26.2.23, |error| < 4.5e-4).
pub(crate) fn upper_normal_quantile(probability: f64) -> f64 {
    let t = (-2.0 * probability.ln()).sqrt();
    t - (2.515_517 + 0.802_853 * t + 0.010_328 * t * t)
        / (1.0 + 1.432_788 * t + 0.189_269 * t * t + 0.001_308 * t * t * t)
}

/// Share of the columns that a frame's own misfit is read from: the best fitting ones. What is wrong with more than half of a frame's
/// columns may still be dirt; what is wrong with four in five is the model.
const BEST: f64 = 0.2;
/// Normal quantile of [`BEST`].
const BEST_QUANTILE: f64 = -0.8416;

/// χ² ratio of the best fitting fifth of a line's usable edges over what noise alone would give; 1 without any.
pub(crate) fn misfit(line: &[Edge], freedom: f64, pool: &mut Vec<f32>) -> f64 {
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

/// χ² ratio of the best fitting fifth below which a frame's noise is not what it was taken for: where an edge has rings, neighbouring columns and
/// pixels differ by these as well as by noise. A fifth of forty edges of a hundred pixels each is known to 3 %.
pub(crate) const MOST_NOISE: f64 = 0.9;

/// Takes the edges' noise for what they leave of the model: `share` of the variance that it was taken for.
pub(crate) fn take_noise_back(line: &mut [Edge], share: f64) {
    for edge in line.iter_mut().filter(|e| e.is_usable()) {
        edge.chi2 /= share as f32;
        edge.u_own_px *= share.sqrt() as f32;
    }
}

/// Standard deviations by which a block's mean χ² ratio must exceed 1 to be a misfit: a block of a clean frame hardly ever does, and its
/// u stays what the noise says.
const MISFIT_LIMIT: f32 = 5.0;
/// Relative standard uncertainty of the noise variance that one frame tells.
const NOISE_KNOWN_TO: f32 = 0.02;

/// Adds to the shared uncertainty what a common misfit may hide. Where the mean residual of neighbours exceeds the noise by
/// λ = ν(χ² − 1), something that all of them share is not in the model (light that falls off across the edge, a film of mist); as much as
/// the residual shows of it may have moved the edge: u = u_own·√λ. `left_px` is what an expected misfit leaves to be stated; what
/// is stated goes to `stated`, one value a block.
pub(crate) fn state_misfit(line: &mut [Edge], freedom: f64, left_px: f64, stated: &mut Vec<f32>) {
    stated.clear();
    for block in line.chunks_mut(MISFIT_BLOCK) {
        let (mut sum, mut count, mut own) = (0.0_f32, 0.0_f32, 0.0_f32);
        for edge in block.iter().filter(|e| e.is_usable()) {
            (sum, count, own) = (sum + edge.chi2, count + 1.0, own + edge.u_own_px * edge.u_own_px);
        }
        // √(2/νn): what a mean over n columns scatters by.
        let excess = MISFIT_LIMIT * (2.0 / (freedom as f32 * count.max(1.0))).sqrt().hypot(NOISE_KNOWN_TO);
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

/// Standard uncertainty beyond which an edge is none, px: what joins the contour of a cloud or of a chip fits so badly that the misfit
/// stated comes to pixels, where a part's faint edge has a fraction of one. Edges with a reason of their own (clipped light, stated
/// with √2) may have more.
const VAGUE_PX: f64 = 0.5;
const VAGUE_IMPAIRED_PX: f64 = 2.9;

/// Refuses edges that are known too badly to be the part's.
pub(crate) fn refuse_vague(line: &mut [Edge]) {
    for edge in line.iter_mut() {
        let limit = if edge.state == EdgeState::Good { VAGUE_PX } else { VAGUE_IMPAIRED_PX };
        if edge.is_usable() && !(edge.u_px() <= limit) {
            edge.state = EdgeState::Gap(Reason::Residual);
        }
    }
}

/// Medians of the usable edges in groups of neighbours, as (column, row).
fn medians(line: &[Edge], pool: &mut Vec<f64>, out: &mut Vec<(f64, f64)>) {
    out.clear();
    for (index, chunk) in line.chunks(NEIGHBOURS).enumerate() {
        pool.clear();
        let mut column = 0.0;
        for (offset, edge) in chunk.iter().enumerate().filter(|(_, e)| e.is_usable()) {
            pool.push(edge.row_px);
            column += offset as f64;
        }
        if pool.len() >= 4 {
            let middle = pool.len() / 2;
            let column = column / pool.len() as f64 + (index * NEIGHBOURS) as f64;
            let (_, median, _) = pool.select_nth_unstable_by(middle, f64::total_cmp);
            out.push((column, *median));
        }
    }
}

/// Scratch of [`refuse_outliers`].
#[derive(Clone, Debug, Default)]
pub(crate) struct OutlierScratch {
    pool: Vec<f64>,
    medians: Vec<(f64, f64)>,
}

impl OutlierScratch {
    /// Makes room for lines of so many columns.
    pub(crate) fn reserve(&mut self, columns: usize) {
        self.pool.reserve(NEIGHBOURS.saturating_sub(self.pool.len()));
        self.medians.reserve((columns / NEIGHBOURS + 1).saturating_sub(self.medians.len()));
    }
}

/// Refuses edges further than `limit_px` (and six standard uncertainties) from the line through the medians of their neighbourhood.
/// Where the medians themselves bend, the bend is allowed on top.
pub(crate) fn refuse_outliers(line: &mut [Edge], limit_px: f64, scratch: &mut OutlierScratch) {
    if is_quiet(line, limit_px) {
        return;
    }
    medians(line, &mut scratch.pool, &mut scratch.medians);
    let knots = &scratch.medians;
    if knots.len() < 2 {
        return;
    }
    let mut left = 0;
    for (column, edge) in line.iter_mut().enumerate() {
        let at = column as f64;
        while left + 2 < knots.len() && knots[left + 1].0 <= at {
            left += 1;
        }
        if !edge.is_usable() {
            continue;
        }
        let (a, b) = (knots[left], knots[left + 1]);
        let slope = (b.1 - a.1) / (b.0 - a.0);
        let expected = a.1 + slope * (at - a.0);
        let departure = (edge.row_px - expected).abs();
        if !(departure <= limit_px) && !(departure <= limit_px.max(6.0 * edge.u_px()) + bend(knots, left)) {
            edge.state = EdgeState::Gap(Reason::Outlier);
        }
    }
}

/// Whether no edge of a line can be an outlier: every three neighbouring groups are complete and, about the line through the ends, span
/// so little that nothing between their medians (nor beyond them, at the ends) lies `limit_px` away.
fn is_quiet(line: &[Edge], limit_px: f64) -> bool {
    let (Some(first), Some(last)) = (line.first(), line.last()) else { return true };
    let slope = (last.row_px - first.row_px) / line.len() as f64;
    let mut before = [(f64::INFINITY, f64::NEG_INFINITY); 2];
    for (index, group) in line.chunks(NEIGHBOURS).enumerate() {
        let (mut low, mut high, mut usable) = (f64::INFINITY, f64::NEG_INFINITY, true);
        for (offset, edge) in group.iter().enumerate() {
            let row = edge.row_px - slope * (index * NEIGHBOURS + offset) as f64;
            low = if row < low { row } else { low };
            high = if row > high { row } else { high };
            usable &= edge.is_usable() & row.is_finite();
        }
        let lowest = before.iter().fold(low, |l, b| l.min(b.0));
        let highest = before.iter().fold(high, |h, b| h.max(b.1));
        // An extrapolation reaches half as far again, beyond a short last group a little farther.
        if !(usable && 1.75 * (highest - lowest) <= limit_px) {
            return false;
        }
        before = [before[1], (low, high)];
    }
    true
}

/// Half the largest second difference of the medians around an interval, px: what a line misses of an arc, at the ends too.
fn bend(knots: &[(f64, f64)], left: usize) -> f64 {
    let second = |k: usize| (knots[k + 1].1 - 2.0 * knots[k].1 + knots[k - 1].1).abs();
    let before = if left >= 1 { second(left) } else { 0.0 };
    let after = if left + 2 < knots.len() { second(left + 1) } else { 0.0 };
    0.5 * before.max(after)
}

/// The largest step from one column to the next of a line without gaps, px; infinite where there is one.
pub(crate) fn largest_jump(line: &[Edge]) -> f64 {
    let (mut most, mut whole) = (0.0_f64, true);
    let mut last = line.first().map_or(f64::NAN, |edge| edge.row_px);
    for edge in line {
        let jump = (edge.row_px - last).abs();
        most = if jump > most { jump } else { most };
        whole &= edge.is_usable() & jump.is_finite();
        last = edge.row_px;
    }
    if whole { most } else { f64::INFINITY }
}

/// Shortest run of columns that counts as a contour, and the gap that does not end one.
const CONTOUR: usize = 32;
const BRIDGE: usize = 8;

/// Fraction of the usable columns that lie in runs of at least 32 columns (half the frame, in narrower ones) along which
/// neither edge jumps: near 1 for a part, small for blobs of noise that happen to have edges.
pub(crate) fn coherence(top: &[Edge], bottom: &[Edge], jump_px: f64) -> f64 {
    let contour = CONTOUR.min(top.len() / 2).max(1);
    let (mut all, mut coherent, mut run) = (0_usize, 0_usize, 0_usize);
    let mut last: Option<(usize, f64, f64)> = None;
    let mut close = |run: usize| coherent += if run >= contour { run } else { 0 };
    for (column, (t, b)) in top.iter().zip(bottom).enumerate() {
        if !(t.is_usable() && b.is_usable()) {
            continue;
        }
        all += 1;
        let goes_on = last.is_some_and(|(c, top, bottom)| {
            let gap = column - c;
            let limit = jump_px * gap as f64;
            gap <= BRIDGE && (t.row_px - top).abs() <= limit && (b.row_px - bottom).abs() <= limit
        });
        if !goes_on {
            close(run);
            run = 0;
        }
        run += 1;
        last = Some((column, t.row_px, b.row_px));
    }
    close(run);
    coherent as f64 / all.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{ChiSquared, ContinuousCDF};

    #[test]
    fn residual_limit_agrees_with_the_distribution() {
        for (freedom, tail) in [(10.0, 1e-5), (14.0, 1e-3), (25.0, 1e-7)] {
            let exact = ChiSquared::new(freedom).unwrap().inverse_cdf(1.0 - tail) / freedom;
            let ours = chi2_ratio_limit(freedom, upper_normal_quantile(tail));
            assert!((ours / exact - 1.0).abs() < 0.02, "{ours} {exact}");
        }
    }

    #[test]
    fn one_stray_edge_is_refused_on_a_slope_and_on_an_arc() {
        let edge =
            |row_px| Edge { row_px, u_own_px: 0.01, u_shared_px: 0.0, chi2: 1.0, state: EdgeState::Good };
        for bent in [0.0, 1.0 / 1000.0] {
            let mut line: Vec<Edge> =
                (0..300).map(|c| edge(0.1 * f64::from(c) + bent * f64::from(c * c))).collect();
            line[77].row_px += 4.0;
            refuse_outliers(&mut line, 1.5, &mut OutlierScratch::default());
            let refused: Vec<usize> = (0..300).filter(|c| !line[*c].is_usable()).collect();
            assert_eq!(refused, [77]);
        }
    }
}
