//! The blur of a frame, from the frame: the edge-spread function's width by pooled scoring over
//! many columns.
//!
//! With the position profiled out the score for σ of one column is Σ r ∂E/∂σ v_mid/v; its sum over
//! columns divided by the pooled information is the Gauss-Newton step. Blocks along the shaft are
//! estimated by themselves and joined unless they differ.

use super::levels::LevelCurve;
use super::scoring::{dot, locate, normalise};
use super::scoring_table::{ScoringTableLimits, Table, Tabulation};
use crate::gauge::edge::image::scan_windows::Windows;
use crate::gauge::edge::model::edge_spread::{EdgeSpreadFunction, EdgeSpreadLimits};
use crate::gauge::edge::model::gaussian::column_sigma;
use crate::gauge::edges::Edge;
use crate::gauge::limit::limits;

limits! {
    /// From which columns the blur of a side is estimated, and what counts as its course along the
    /// field.
    BlurLimits = "blur";
    /// Columns looked at per block while the blur converges: its last step takes `final_per_block`.
    /// Tuned: see study limits.
    per_block: usize = 32;
    /// Columns looked at per block in the last step and in what a stream follows: in these a frame
    /// by itself and a stream look at the same columns, so that they differ by what the frames
    /// before add alone. Tuned: see study limits.
    final_per_block: usize = 128;
    /// Fewest columns of a block whose blur counts as known where a course is laid through the
    /// blocks. Tuned: see study limits.
    least_count: f64 = 6.0;
    /// Contrast of a window's ends over the largest contrast in the window above which it contains
    /// one edge alone: noise of a tenth of the contrast and light that falls by 4:1 over a field
    /// leave more, a second edge leaves less.
    least_at_ends: f32 = 0.7;
    /// Slope of an edge, rows per column, above which a column takes no part in estimates of blur
    /// and shape: the blur along the column is then √(1 + 0.3²), 4 % more than that across the
    /// edge.
    steepest: f64 = 0.3;
    /// Relative half width within which the width of a ringed pattern may differ from its nominal
    /// one: √(λz/2) of a distance z that is given to within −28 and +32 %.
    ringed_search: f64 = 0.15;
    /// Greatest change of the phase of the farthest ring between two widths tried, rad: scoring
    /// converges from half of it.
    ring_phase: f64 = 1.0;
    /// Standard deviation of trend and bend of the blur along the field that are likely, as a share
    /// of the blur: a shaft that sags by half a millimetre towards the camera is blurred by some
    /// hundredths otherwise at the ends of a field.
    likely_course: f64 = 0.03;
    /// Least difference along the field, as a share of the blur, that counts: it moves an edge by a
    /// thousandth of a pixel. Frames without noise show smaller ones of the edge model.
    least_course: f64 = 0.002;
    /// Mean square of the residuals over the noise variance from which on they are the edge
    /// model's: then half of it is.
    systematic_ratio: f64 = 2.0;
    /// χ² of a trend and a bend (two degrees of freedom) that is significant where the residuals
    /// are the edge model's: false alarms in 1 % of the frames.
    significant_chi2: f64 = 9.2;
    /// Most that the blocks may leave of χ² about trend and bend, each degree of freedom: noise
    /// leaves more of five degrees in 1 % of the frames. What is no smooth course along the field
    /// is contamination.
    rough_chi2: f64 = 3.0;
    /// Slope of an edge, rows per column, below which the blur along the column is taken for that
    /// across the edge: σ²(1 + t²) + t²/12 is off by 0.2 % of σ at most (σ ≥ 0.4 px).
    level_slope: f32 = 0.05;
}

/// Blocks along the shaft.
pub(crate) const BLOCKS: usize = 8;

/// Sums for the blur of one block.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BlurSums {
    pub(crate) score: f64,
    pub(crate) information: f64,
    residual: f64,
    pub(crate) count: f64,
}

/// Place of a block's middle along the field, −½ to ½.
pub(crate) fn middle(block: usize) -> f64 {
    (block as f64 + 0.5) / BLOCKS as f64 - 0.5
}

/// Blur of one side in each block, px.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BlurEstimate {
    pub(crate) sigma: [f64; BLOCKS],
}

impl BlurEstimate {
    pub(crate) fn uniform(sigma: f64) -> Self {
        Self { sigma: [sigma; BLOCKS] }
    }

    /// Block of a column.
    pub(crate) fn block(column: usize, columns: usize) -> usize {
        (column * BLOCKS / columns.max(1)).min(BLOCKS - 1)
    }

    /// Columns of a block: those c with c·BLOCKS/columns = block.
    pub(crate) fn columns(block: usize, columns: usize) -> std::ops::Range<usize> {
        let first = |block: usize| (block * columns).div_ceil(BLOCKS);
        first(block)..first(block + 1)
    }

    /// End of the columns from `from` on that have the same blur.
    pub(crate) fn end_of_run(&self, from: usize, columns: usize) -> usize {
        let block = Self::block(from, columns);
        let own = self.sigma[block].to_bits();
        let other = (block..BLOCKS).find(|b| self.sigma[*b].to_bits() != own);
        other.map_or(columns, |b| Self::columns(b, columns).start).max(from + 1)
    }

    /// Keeps the blur of all blocks within its bounds.
    pub(crate) fn limit(&mut self, least: f64) {
        let most = EdgeSpreadLimits::get().most_sigma_px;
        self.sigma.iter_mut().for_each(|s| *s = s.clamp(least, most));
    }

    pub(crate) fn mean(&self) -> f64 {
        self.sigma.iter().sum::<f64>() / BLOCKS as f64
    }
}

/// Columns of a block that are looked at, at most `most` or little more.
pub(crate) fn sample(block: usize, columns: usize, most: usize) -> impl Iterator<Item = usize> {
    let (from, to) = (block * columns / BLOCKS, (block + 1) * columns / BLOCKS);
    let step = (to - from).div_ceil(most).max(1);
    (from..to).step_by(step)
}

/// Number of columns that a frame's blur is estimated from.
pub(crate) fn estimated_from(columns: usize) -> usize {
    let most = BlurLimits::get().final_per_block;
    (0..BLOCKS).map(|block| sample(block, columns, most).count()).sum()
}

/// Columns of all blocks that are looked at.
pub(crate) fn samples(columns: usize) -> impl Iterator<Item = usize> {
    let most = BlurLimits::get().per_block;
    (0..BLOCKS).flat_map(move |block| sample(block, columns, most))
}

/// Rough blur from Σ n(1 − n) = (total standard deviation)/√π over the windows' central parts;
/// `None` without contrast. The windows are those of the columns looked at, one after the other.
pub(crate) fn rough(windows: &Windows, pool: &mut Vec<f32>) -> Option<f64> {
    pool.clear();
    for place in 0..windows.centre.len() {
        if windows.centre[place].is_err() {
            continue;
        }
        let (dark, light) = (windows.dark[place], windows.light[place]);
        let window = windows.of(place);
        let flat = windows.flat;
        let n = |m: &f32| (m - dark) / (light - dark);
        let spread = |part: &[f32]| part.iter().map(|m| n(m) * (1.0 - n(m))).sum::<f32>();
        let used = window.len() - 1;
        // The sum over the flat ends is noise (−σ_n² a pixel): scaled to the window, it is
        // subtracted.
        let ends = spread(&window[..flat]) + spread(&window[used - flat..used]);
        let middle = spread(&window[flat..used - flat]);
        pool.push(middle - ends * (used - 2 * flat) as f32 / (2 * flat) as f32);
    }
    if pool.len() < 4 {
        return None;
    }
    let middle = pool.len() / 2;
    let (_, median, _) = pool.select_nth_unstable_by(middle, f32::total_cmp);
    let total = f64::from(*median) * std::f64::consts::PI.sqrt();
    let EdgeSpreadLimits { least_sigma_px, most_sigma_px, .. } = *EdgeSpreadLimits::get();
    Some((total * total - 1.0 / 12.0).max(0.04).sqrt().clamp(least_sigma_px, most_sigma_px))
}

/// Whether most windows contain one edge alone: their outermost pixels hold most of the contrast in
/// the window. Where a window reaches another shadow, or the part's other edge, they do not.
pub(crate) fn sees_one_edge(windows: &Windows) -> bool {
    let least_at_ends = BlurLimits::get().least_at_ends;
    let (mut alone, mut seen) = (0_usize, 0_usize);
    for place in (0..windows.centre.len()).filter(|place| windows.centre[*place].is_ok()) {
        let window = windows.of(place);
        let used = &window[..window.len() - 1];
        let mean = |three: &[f32]| three.iter().sum::<f32>() / 3.0;
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for value in used.windows(3).map(mean) {
            (low, high) = (low.min(value), high.max(value));
        }
        let ends = mean(&used[used.len() - 3..]) - mean(&used[..3]);
        seen += 1;
        alone += usize::from(ends > least_at_ends * (high - low));
    }
    2 * alone > seen
}

/// What a refinement needs beside the windows.
pub(crate) struct BlurContext<'a> {
    pub(crate) windows: &'a Windows,
    pub(crate) shape: &'a EdgeSpreadFunction,
    pub(crate) dark: &'a LevelCurve,
    pub(crate) light: &'a LevelCurve,
    pub(crate) slope: &'a [f32],
    /// Edges found with an earlier blur; refused ones are left out.
    pub(crate) line: Option<&'a [Edge]>,
    /// Whether columns are readings one after the other: no course along the field.
    pub(crate) level_lines: bool,
    pub(crate) kappa: f64,
    /// Noise variance at mid-edge over contrast².
    pub(crate) relative_variance: f64,
}

impl BlurContext<'_> {
    /// The table of a blur tried.
    fn tabulation(&self, sigma: f64) -> Tabulation {
        let (kappa, width) = (self.kappa, self.windows.width);
        Tabulation { sigma, kappa, width, free_levels: false, per_px: ScoringTableLimits::get().coarse }
    }
}

/// Memory of [`refine`].
#[derive(Clone, Debug)]
pub(crate) struct BlurScratch {
    table: Table,
    normalised: Vec<f32>,
}

impl BlurScratch {
    pub(crate) fn new() -> Self {
        Self { table: Table::empty(), normalised: Vec::new() }
    }
}

/// Refines the blur of one side from `start`, px.
pub(crate) fn refine(context: &BlurContext<'_>, start: f64, scratch: &mut BlurScratch) -> BlurEstimate {
    let limits = BlurLimits::get();
    let columns = context.windows.centre.len();
    let mut sigma = if context.shape.is_ringed() { best_of_rings(context, start, scratch) } else { start };
    let mut sums = [BlurSums::default(); BLOCKS];
    let BlurScratch { table, normalised } = scratch;
    normalised.resize(context.windows.width, 0.0);
    for _ in 0..8 {
        table.fill(context.shape, context.tabulation(sigma));
        for (block, sum) in sums.iter_mut().enumerate() {
            *sum = block_sums(context, table, sample(block, columns, limits.per_block), normalised);
        }
        let score: f64 = sums.iter().map(|s| s.score).sum();
        let information: f64 = sums.iter().map(|s| s.information).sum();
        if !(information > 0.0) {
            return BlurEstimate::uniform(sigma);
        }
        let step = (score / information).clamp(-0.3 * sigma, 0.5 * sigma);
        let last = sigma;
        sigma = (sigma + step).clamp(context.shape.least_sigma(), context.shape.most_sigma());
        if (sigma - last).abs() < 5e-4 * sigma {
            break;
        }
    }
    // The course along the field is determined from more columns than the width itself needs to
    // converge.
    table.fill(context.shape, context.tabulation(sigma));
    for (block, sum) in sums.iter_mut().enumerate() {
        *sum = block_sums(context, table, sample(block, columns, limits.final_per_block), normalised);
    }
    join(context, sigma, &sums)
}

/// The width that leaves the smallest residual of rings among some around `start`: their phase,
/// πv²/2 at v units √(λz/2) from the edge, is proportional to its square, so that scoring from afar
/// would converge on a neighbouring ring.
fn best_of_rings(context: &BlurContext<'_>, start: f64, scratch: &mut BlurScratch) -> f64 {
    let limits = BlurLimits::get();
    let columns = context.windows.centre.len();
    let BlurScratch { table, normalised } = scratch;
    normalised.resize(context.windows.width, 0.0);
    // σ₀ is half a unit: the steepest slope of the pattern is 0.8 a unit.
    let v = context.shape.reach(start) / (2.0 * start);
    let step = limits.ring_phase / (std::f64::consts::PI * v * v).max(1.0);
    let steps = (limits.ringed_search / step).ceil() as i32;
    let mut best = (f64::INFINITY, start);
    for k in -steps..=steps {
        let sigma = start * (1.0 + f64::from(k) * step);
        table.fill(context.shape, context.tabulation(sigma));
        // Few columns show: a pattern is shared by all of them.
        let sums = block_sums(context, table, samples(columns).step_by(8), normalised);
        let left = sums.residual / sums.count;
        if left < best.0 {
            best = (left, sigma);
        }
    }
    best.1
}

fn block_sums(
    context: &BlurContext<'_>,
    table: &Table,
    columns: impl Iterator<Item = usize>,
    normalised: &mut [f32],
) -> BlurSums {
    let steepest = BlurLimits::get().steepest as f32;
    let mut sums = BlurSums::default();
    for column in columns {
        let refused = context.line.is_some_and(|line| !line[column].is_usable());
        if context.windows.centre[column].is_err() || context.slope[column].abs() > steepest || refused {
            continue;
        }
        let (dark, light) = (context.dark.level[column], context.light.level[column]);
        let start = normalise(context.windows.of(column), dark, light - dark, normalised) - table.centroid;
        let Some(found) = locate(normalised, table, start) else { continue };
        let (scalars, blur) = (found.phase.scalars, found.phase.blur);
        let score = dot(found.phase.blur_scores, normalised) - blur.offset - found.step * blur.position;
        sums.score += f64::from(score);
        sums.information += f64::from(blur.information(scalars));
        sums.residual += f64::from(found.residual) / f64::from(scalars.freedom);
        sums.count += 1.0;
    }
    sums
}

/// One blur for all blocks unless they differ significantly and by more than 1 %; then a parabola
/// through them, or a line where few of them are known. Smaller differences count as far as they
/// are likely ([`likely_course`]).
fn join(context: &BlurContext<'_>, sigma: f64, sums: &[BlurSums; BLOCKS]) -> BlurEstimate {
    let slope2 = mean_square_slope(context);
    let least = context.shape.least_sigma();
    let plain = |s: f64| ((s * s - slope2 / 12.0).max(least * least) / (1.0 + slope2)).sqrt();
    let residual: f64 =
        sums.iter().map(|s| s.residual).sum::<f64>() / sums.iter().map(|s| s.count).sum::<f64>().max(1.0);
    let variance = residual.max(context.relative_variance).max(1e-12);
    let good = |s: &&BlurSums| s.information > 0.0;
    let chi2: f64 = sums.iter().filter(good).map(|s| s.score * s.score / s.information / variance).sum();
    let spread = sums.iter().filter(good).map(|s| (s.score / s.information).abs()).fold(0.0, f64::max);
    let systematic = BlurLimits::get().systematic_ratio;
    let far = chi2 >= 26.0 && spread >= 0.01 * sigma;
    let course = match far {
        _ if context.level_lines => None,
        true => parabola(sums),
        false => likely_course(sums, variance, sigma, residual < systematic * context.relative_variance),
    };
    let Some(parabola) = course else {
        return BlurEstimate::uniform(plain(sigma));
    };
    let mut estimate = BlurEstimate::uniform(plain(sigma));
    for (block, value) in estimate.sigma.iter_mut().enumerate() {
        let t = middle(block);
        let delta = parabola[0] + parabola[1] * t + parabola[2] * t * t;
        *value = plain((sigma + delta).clamp(0.5 * sigma, 2.0 * sigma)).max(least);
    }
    estimate
}

fn mean_square_slope(context: &BlurContext<'_>) -> f64 {
    let steepest = BlurLimits::get().steepest;
    let columns = context.windows.centre.len();
    let (mut sum, mut count) = (0.0, 0.0_f64);
    for column in samples(columns) {
        let slope = f64::from(context.slope[column]);
        if slope.is_finite() && slope.abs() <= steepest {
            sum += slope * slope;
            count += 1.0;
        }
    }
    sum / count.max(1.0)
}

/// The parabola that a shaft's distance from the focal plane draws along the field, its trend and
/// bend weighed against what is likely of them: a test of significance would leave out what most
/// frames of a bent shaft show too weakly, and all of them alike.
///
/// Where the residuals are the edge model's and not the noise's (`is_noise` false), they are alike
/// in all frames: there the course must be significant.
fn likely_course(
    sums: &[BlurSums; BLOCKS],
    variance: f64,
    sigma: f64,
    is_noise: bool,
) -> Option<nalgebra::Vector3<f64>> {
    let limits = BlurLimits::get();
    let mut normal = nalgebra::Matrix3::<f64>::zeros();
    let mut right = nalgebra::Vector3::<f64>::zeros();
    let (mut total, mut known) = (0.0, 0.0_f64);
    for (block, sum) in sums.iter().enumerate().filter(|(_, s)| s.information > 0.0) {
        let t = middle(block);
        let basis = nalgebra::Vector3::new(1.0, t, t * t - 1.0 / 12.0);
        normal += basis * basis.transpose() * (sum.information / variance);
        right += basis * (sum.score / variance);
        total += sum.score * sum.score / sum.information / variance;
        known += 1.0;
    }
    let likely = (limits.likely_course * sigma).powi(-2);
    normal[(1, 1)] += likely;
    normal[(2, 2)] += likely;
    let p = normal.try_inverse()? * right;
    let is_smooth = total - p.dot(&right) < limits.rough_chi2 * (known - 3.0).max(1.0);
    let spread = (0.5 * p[1]).abs() + (0.25 * p[2]).abs();
    let by_level = right[0] * right[0] / normal[(0, 0)];
    let is_likely = is_noise || p.dot(&right) - by_level > limits.significant_chi2;
    let counts = is_smooth && is_likely && spread > limits.least_course * sigma;
    counts.then(|| nalgebra::Vector3::new(p[0] - p[2] / 12.0, p[1], p[2]))
}

/// A parabola through the blocks' blurs, or a line where few of them are known.
fn parabola(sums: &[BlurSums; BLOCKS]) -> Option<nalgebra::Vector3<f64>> {
    let least = BlurLimits::get().least_count;
    let known = sums.iter().filter(|s| s.count >= least).count();
    if known < 3 {
        return None;
    }
    let bent = if known < 6 { 0.0 } else { 1.0 };
    let mut normal = nalgebra::Matrix3::<f64>::zeros();
    let mut right = nalgebra::Vector3::<f64>::zeros();
    for (block, sum) in sums.iter().enumerate() {
        let t = middle(block);
        let basis = nalgebra::Vector3::new(1.0, t, bent * t * t);
        normal += basis * basis.transpose() * sum.information;
        right += basis * sum.score;
    }
    normal[(2, 2)] += 1.0 - bent;
    normal.try_inverse().map(|inverse| inverse * right)
}

/// Blur along a column of slope `slope` in a block.
pub(crate) fn at_slope(sigma: f64, slope: f32) -> f64 {
    if slope.abs() < BlurLimits::get().level_slope { sigma } else { column_sigma(sigma, f64::from(slope)) }
}

#[cfg(test)]
mod tests;
