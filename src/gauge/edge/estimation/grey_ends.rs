//! Where the grey scale of a frame ends: found from its grey values, whatever their container could
//! hold.
//!
//! Cameras clip below full scale (254, 235, 1023 in 16 bits, a 12-bit value shifted left), some
//! pixels are hot, some frames carry no noise. Flat light is clipped where its grey values pile up
//! at their largest one: more of them there than in the step below, and none beyond where the noise
//! seen elsewhere (in the pairs below that value, on the other level, on the flank) implies there
//! should be some. A frame that shows no noise anywhere is not clipped. The lower end is found in
//! the same way, with signs turned.

use crate::gauge::edge::image::scan_windows::Windows;
use crate::gauge::limit::limits;
use crate::numerics::distributions::{inverse_tail, phi_cdf};
use crate::numerics::robust::upper_median;

limits! {
    /// What separates the end of a grey scale from a level that has a few equal pixels.
    GreyEndLimits = "grey_ends";
    /// Columns looked at before anything looks clipped: five flat pixels each, which miss a share
    /// of `at_one` once in 120 (0.985³²⁰).
    glance_columns: usize = 64;
    /// Share of the flat pixels that may lie beyond an end: hot pixels. Less than this clipped
    /// moves a level by 0.016 standard deviations.
    beyond: f64 = 0.04;
    /// Share of the flat pixels at one grey value from which on it may be an end. Tuned: see study
    /// limits.
    at_one: f64 = 0.015;
    /// Times as many pixels at an end as in the step before it: a tail that is not clipped has
    /// fewer in each further step, and half as many more leave room for chance. Tuned: see study
    /// limits.
    piled: f64 = 1.5;
    /// Pixels expected beyond an end, none seen, that are evidence of it: chance leaves none of ten
    /// once in 20 000.
    expected: f64 = 10.0;
    /// Share of the pixels expected beyond an end that may be seen there: hot ones.
    seen: f64 = 0.2;
    /// Fewest pairs of pixels from which a noise is estimated: a variance from 32 is known to
    /// √(2/32), a quarter.
    least_pairs: usize = 32;
    /// Largest number of flat pixels evaluated: a variance from them is known to √(2/4096) = 2 %.
    most_pixels: usize = 4096;
    /// Scatter that counts as noise, in steps of the grey scale: a level half-way between two steps
    /// toggles under the least noise: √(1/4 − 1/12) = 0.41 are left without rounding's own.
    least_noise_steps: f64 = 0.45;
    /// Scatter that counts as noise where the grey scale has no step, of the contrast: below, the
    /// part's own drift through the pixels scatters as much (`soft_knee.least_noise`).
    least_noise_contrast: f64 = 1e-3;
}

/// Variance of a mean of squared second differences of successive pixels, over that of as many
/// independent ones: neighbours share pixels, correlations −4/6 and 1/6, so 1 + 2·(16 + 1)/36.
const SECOND_DIFFERENCES: f64 = 1.0 + 2.0 * 17.0 / 36.0;

/// Which flat end of the windows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Level {
    Dark,
    Light,
}

impl Level {
    /// Grey values are multiplied by this: an end is then the largest value.
    pub(crate) fn sign(self) -> f32 {
        if self == Self::Light { 1.0 } else { -1.0 }
    }

    fn pixels(self, windows: &Windows) -> std::ops::Range<usize> {
        let used = windows.width - 1;
        if self == Self::Light { used - windows.flat..used } else { 0..windows.flat }
    }
}

/// What is known of a side's noise, counts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Elsewhere {
    /// Standard deviation in the dark and in the light as differences show it; NaN where not known.
    pub(crate) noise: [f64; 2],
    /// Mean levels.
    pub(crate) levels: [f64; 2],
    /// Step of the grey scale, counts; 0 where there is none.
    pub(crate) step: f64,
    /// Whether grey values have their signs turned (a lit part before a dark ground): photons'
    /// noise is then that of the level called dark.
    pub(crate) turned: bool,
}

/// Whether there is any evidence of an end at a level, from a few pixels.
pub(crate) fn may_end(windows: &Windows, level: Level, pool: &mut Vec<f32>) -> bool {
    collect(windows, level, GreyEndLimits::get().glance_columns, pool);
    candidate(pool).is_some_and(|end| stands_out(pool, end))
}

/// Whether at least as many pixels stand at a grey value as at the next one below: on the outer
/// slope of a bell fewer do.
fn stands_out(pool: &[f32], end: f32) -> bool {
    let below = pool.iter().copied().filter(|v| *v < end).fold(f32::NEG_INFINITY, f32::max);
    let (at_end, before) = pool.iter().fold((0, 0), |(at_end, before), v| {
        (at_end + usize::from(*v == end), before + usize::from(*v == below))
    });
    at_end >= before
}

/// The grey value at which a level of the side is clipped; `None` where it is not.
pub(crate) fn find_end(
    windows: &Windows,
    level: Level,
    elsewhere: &Elsewhere,
    (pool, squares): (&mut Vec<f32>, &mut Vec<f32>),
) -> Option<(f32, f64)> {
    collect(windows, level, GreyEndLimits::get().most_pixels / windows.flat.max(1), pool);
    let contrast = elsewhere.levels[1] - elsewhere.levels[0];
    let found = judge(pool, elsewhere.step, contrast, |end, least, step| {
        reference_noise(windows, level, Presumed { end, least, step }, elsewhere, squares)
    });
    found.map(|(end, step)| (level.sign() * end, step))
}

/// The grey value at which flat pixels are clipped, their largest, and the distance of two grey
/// values; `None` where they are not. `known_step`: step of the grey scale, 0 where there is none.
/// `noise` gives what they should scatter by, from a presumed end, the least scatter that counts
/// and the distance of two grey values.
pub(crate) fn judge(
    pool: &mut [f32],
    known_step: f64,
    contrast: f64,
    noise: impl FnOnce(f32, f64, f64) -> f64,
) -> Option<(f32, f64)> {
    let limits = GreyEndLimits::get();
    let end = candidate(pool)?;
    let all = pool.len() as f64;
    let step = f64::from(grid(pool)).max(known_step);
    let count = |from: f32, to: f32| pool.iter().filter(|v| **v >= from && **v < to).count() as f64;
    let at_end = pool.iter().filter(|v| **v == end).count() as f64;
    // At least a step is looked at below: for most levels this suffices, without their noise.
    if !(at_end > limits.piled * count(end - step as f32, end)) {
        return None;
    }
    let of_contrast = if known_step > 0.0 { 0.0 } else { limits.least_noise_contrast * contrast };
    let least = (limits.least_noise_steps * step).max(of_contrast);
    let noise = noise(end, least, step);
    if !(noise > least) {
        return None;
    }
    let apart = (0.5 * noise).max(step);
    let before = count(end - apart as f32, end);
    // Of a Gaussian with this share above its last grey value, the share a step farther out.
    let share = (at_end / all).min(1.0 - 1.0 / all);
    let beyond = all * phi_cdf(-(inverse_tail(share) + apart / noise));
    // Hot pixels stand anywhere beyond, the other half of a bell right behind.
    let behind = count(end, end + 2.0 * (noise as f32).max(apart as f32)) - at_end;
    let is_end = at_end > limits.piled * before && beyond > limits.expected && behind < limits.seen * beyond;
    is_end.then_some((end, step))
}

/// Noise expected of a level from that on the flank and that of the other level, counts.
/// `brighter`: whether it is the level of more light; `known_to` is the relative standard
/// uncertainty of the flank's variance.
pub(crate) fn expected_noise(brighter: bool, (flank, known_to): (f64, f64), other: f64) -> f64 {
    match brighter {
        // Light has the noise of the dark, and its photons'.
        true => flank.max(other),
        // In the dark the photons' noise is missing: the intercept of a line through light and
        // flank remains.
        false => {
            let left = 2.0 * flank * flank - other * other;
            if left > (6.0 * known_to).max(0.3) * flank * flank { left.sqrt() } else { 0.0 }
        }
    }
}

/// Flat pixels of a level in about so many columns, sign turned in the dark.
fn collect(windows: &Windows, level: Level, columns: usize, pool: &mut Vec<f32>) {
    pool.clear();
    let step = windows.centre.len().div_ceil(columns.max(1)).max(1);
    let range = level.pixels(windows);
    for column in (0..windows.centre.len()).step_by(step).filter(|c| windows.centre[*c].is_ok()) {
        pool.extend(windows.of(column)[range.clone()].iter().map(|v| level.sign() * v));
    }
}

/// The grey value that all but [`GreyEndLimits::beyond`] of the pixels stay at or below, where many
/// stand at it.
fn candidate(pool: &mut [f32]) -> Option<f32> {
    if pool.len() < 24 {
        return None;
    }
    let limits = GreyEndLimits::get();
    let at = ((1.0 - limits.beyond) * pool.len() as f64) as usize;
    let end = *pool.select_nth_unstable_by(at, f32::total_cmp).1;
    let equal = pool.iter().filter(|v| **v == end).count();
    (equal as f64 >= limits.at_one * pool.len() as f64).then_some(end)
}

/// Smallest distance of two grey values of the level; 0 where there is one only. What hot pixels
/// and dead ones show is no value of the level.
fn grid(pool: &mut [f32]) -> f32 {
    pool.sort_unstable_by(f32::total_cmp);
    let defects = (GreyEndLimits::get().beyond * pool.len() as f64) as usize;
    let level = &pool[defects..pool.len() - defects];
    let apart = level.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0);
    let least = apart.fold(f32::INFINITY, f32::min);
    if least.is_finite() { least } else { 0.0 }
}

/// An end of the grey values that is to be confirmed.
#[derive(Clone, Copy, Debug)]
struct Presumed {
    /// The grey value, sign turned in the dark.
    end: f32,
    /// Least scatter that counts, counts.
    least: f64,
    /// Distance of two grey values, counts.
    step: f64,
}

/// Noise that the level should show, counts: that of its pixels below the end, where they show
/// more than the least; else what the other level and the flank imply.
fn reference_noise(
    windows: &Windows,
    level: Level,
    Presumed { end, least, step }: Presumed,
    elsewhere: &Elsewhere,
    squares: &mut Vec<f32>,
) -> f64 {
    let rounding = step * step / 12.0;
    let below =
        below_noise(windows, level, (end, step), squares).map_or(0.0, |s| (s * s - rounding).max(0.0).sqrt());
    if below > least {
        return below;
    }
    // A flank without noise that moves by half a step a column rounds up and down in turn: its
    // second differences are then all one step, and their variance over 6 twice that of rounding.
    // In the dark, where twice the flank's variance is extrapolated from, that would be a noise.
    let brighter = (level == Level::Light) != elsewhere.turned;
    let flank_rounding = if brighter { rounding } else { 2.0 * rounding };
    let flank =
        flank_noise(windows, elsewhere, squares).map_or(0.0, |s| (s * s - flank_rounding).max(0.0).sqrt());
    let known_to = (2.0 * SECOND_DIFFERENCES / squares.len().max(1) as f64).sqrt();
    let other = |k: usize| {
        let s = elsewhere.noise[k];
        if s.is_finite() { (s * s - rounding).max(0.0).sqrt() } else { 0.0 }
    };
    expected_noise(brighter, (flank, known_to), other(if level == Level::Light { 0 } else { 1 }))
}

/// Noise of neighbouring flat pixels neither of which stands at the end.
fn below_noise(
    windows: &Windows,
    level: Level,
    (end, apart): (f32, f64),
    squares: &mut Vec<f32>,
) -> Option<f64> {
    let range = level.pixels(windows);
    let columns = windows.centre.len();
    let step = columns.div_ceil(2 * GreyEndLimits::get().most_pixels / windows.flat.max(1)).max(2);
    squares.clear();
    for column in (0..columns.saturating_sub(1)).step_by(step) {
        if windows.centre[column].is_err() || windows.centre[column + 1].is_err() {
            continue;
        }
        let pair = windows.of(column)[range.clone()].iter().zip(&windows.of(column + 1)[range.clone()]);
        let inside = |v: &f32| level.sign() * v < end;
        squares.extend(pair.filter(|(a, b)| inside(a) && inside(b)).map(|(a, b)| (a - b).powi(2)));
    }
    robust_mean(squares, apart).map(|mean| (0.5 * mean).sqrt())
}

/// Noise of pairs of pixels neither of which stands at an end, counts; `None` of too few. `step` is
/// the distance of two grey values, counts, 0 where there is none.
pub(crate) fn noise_of_pairs(pairs: impl Iterator<Item = [f32; 2]>, end: f32, step: f64) -> Option<f64> {
    let below = pairs.filter(|[a, b]| *a < end && *b < end);
    let mut squares: Vec<f32> = below.map(|[a, b]| (a - b).powi(2)).collect();
    robust_mean(&mut squares, step).map(|mean| (0.5 * mean).sqrt())
}

/// Variance of the flat light by neighbouring columns, clipped pixels included, counts², and the
/// share of them at the end or beyond; `None` of too few. `apart` is the distance of two grey
/// values, counts.
pub(crate) fn light_scatter(
    windows: &Windows,
    (end, apart): (Option<f32>, f64),
    squares: &mut Vec<f32>,
) -> Option<(f64, f64)> {
    let range = Level::Light.pixels(windows);
    let columns = windows.centre.len();
    let step = columns.div_ceil(2 * GreyEndLimits::get().most_pixels / windows.flat.max(1)).max(2);
    squares.clear();
    let (mut at_end, mut all) = (0.0, 0.0_f64);
    for column in (0..columns.saturating_sub(1)).step_by(step) {
        if windows.centre[column].is_err() || windows.centre[column + 1].is_err() {
            continue;
        }
        let pair = windows.of(column)[range.clone()].iter().zip(&windows.of(column + 1)[range.clone()]);
        for (a, b) in pair {
            squares.push((a - b).powi(2));
            (at_end, all) = (at_end + f64::from(u8::from(end.is_some_and(|end| *a >= end))), all + 1.0);
        }
    }
    // Most pairs of clipped light are equal: their median is no measure of scatter.
    let mean = match end {
        Some(_) if squares.len() >= GreyEndLimits::get().least_pairs => {
            squares.iter().map(|s| f64::from(*s)).sum::<f64>() / squares.len() as f64
        }
        _ => robust_mean(squares, apart)?,
    };
    Some((0.5 * mean, at_end / all.max(1.0)))
}

/// Noise on the flank by second differences along the shaft of the two pixels about the middle of
/// the levels, less what an edge that moves would do to both: structure of the part is no noise.
pub(crate) fn flank_noise(windows: &Windows, elsewhere: &Elsewhere, squares: &mut Vec<f32>) -> Option<f64> {
    let middle = (0.5 * (elsewhere.levels[0] + elsewhere.levels[1])) as f32;
    let columns = windows.centre.len();
    let step = columns.div_ceil(GreyEndLimits::get().most_pixels).max(1);
    squares.clear();
    for column in (1..columns.saturating_sub(1)).step_by(step) {
        let Ok(centre) = windows.centre[column] else { continue };
        if windows.centre[column - 1] != Ok(centre) || windows.centre[column + 1] != Ok(centre) {
            continue;
        }
        let window = &windows.of(column)[..windows.width - 1];
        // The pair whose mean is the middle: one of the pixel nearest to it and the next into the
        // light would state a noise nearer to the light's.
        let off = |at: &usize| (0.5 * (window[*at] + window[*at + 1]) - middle).abs();
        let Some(nearest) = (1..window.len() - 2).min_by(|a, b| off(a).total_cmp(&off(b))) else { continue };
        let [before, after] = [column - 1, column + 1].map(|c| windows.of(c));
        let bend = |at: usize| before[at] - 2.0 * window[at] + after[at];
        let rise = |at: usize| window[at + 1] - window[at - 1];
        let rises = [rise(nearest), rise(nearest + 1)];
        let length = rises[0].hypot(rises[1]);
        if length > 0.0 {
            let own = (bend(nearest) * rises[1] - bend(nearest + 1) * rises[0]) / length;
            squares.push(own * own);
        }
    }
    robust_mean(squares, elsewhere.step).map(|mean| (mean / 6.0).sqrt())
}

/// Mean of squares without those beyond 36 times the median one; `None` of too few. Where most are
/// 0 (whole counts, a scatter below half a step), those beyond four steps are left out: hot pixels,
/// which such a scatter does not reach. `step` is the distance of two grey values, counts; where it
/// is 0, the root of the least square that is not takes its place.
pub(crate) fn robust_mean(squares: &mut [f32], step: f64) -> Option<f64> {
    if squares.len() < GreyEndLimits::get().least_pairs {
        return None;
    }
    let median = upper_median(squares, f32::total_cmp)?;
    let least = || squares.iter().copied().filter(|s| *s > 0.0).fold(f32::INFINITY, f32::min);
    let cut = match (median > 0.0, step > 0.0) {
        (true, _) => 36.0 * 2.2 * median,
        (false, true) => 16.0 * (step * step) as f32,
        (false, false) => 16.0 * least(),
    };
    let kept = squares.iter().filter(|s| **s <= cut);
    let (sum, count) = kept.fold((0.0, 0.0), |(sum, count), s| (sum + f64::from(*s), count + 1.0));
    Some(sum / f64::max(count, 1.0))
}

#[cfg(test)]
mod tests;
