//! The effect of rounding to whole counts on an edge where noise does not spread the grey values
//! over several of them.
//!
//! A grey value m with normal noise of standard deviation σ, rounded to multiples of q, has the
//! mean m + b(m) with (B. Widrow and I. Kollár, Quantization Noise, 2008, chapters 4 and 5)
//!
//! ```text
//! b(m) = q Σ_k (−1)^k/(πk)·exp(−2π²k²σ²/q²)·sin(2πkm/q)
//! mean of b² over m:  r(σ) = q² Σ_k 1/(2π²k²)·exp(−4π²k²σ²/q²)
//! ```
//!
//! r is q²/12 without noise, a thirtieth of that at σ = 0.27 q, nothing from 0.5 q on. b is the
//! same wherever m is the same: in every column of a level edge and in every frame. So the fraction
//! of an edge's variance that is due to r,
//!
//! ```text
//! f = Σ w_k² r(σ_k) / Σ w_k² v_k        w the weights of the fit, v the variances of the pixels
//! ```
//!
//! is shared by its neighbours and common to all frames, instead of averaging. Only where an edge
//! runs over several counts along the columns does it repeat less: over S rows it meets 1 +
//! C·|E′|·S/q of them. The levels of light and shadow carry r of their own, the same at both edges
//! where both see the same light.

use super::noise::Spread;
use crate::gauge::edge::model::edge_spread::EdgeSpreadFunction;
use crate::gauge::edge::model::gaussian::EdgeSample;
use crate::gauge::edges::Edge;
use crate::gauge::limit::limits;

limits! {
    /// When rounding repeats, and over which columns.
    RoundingLimits = "rounding";
    /// Noise in steps of the grey scale beyond which r is below 1e-5 of its largest value:
    /// 12·exp(−4π²·0.55²)/(2π²) = 4e-6.
    dithered: f64 = 0.55;
    /// Columns over which a local mean is taken: those of the largest diameter's median.
    local_columns: usize = 64;
    /// Columns whose phases are looked at, evenly along the edge. Tuned: see study limits.
    looked_at: usize = 8;
    /// Share of repetition in neighbouring edges that differences show beyond chance: of the few
    /// hundred that there are at least, their variance is known to 10 % (false alarms in 0.6 % of
    /// the sides).
    shown: f64 = 0.25;
    /// Fraction of differences of two steps and more below which grey values take only two
    /// neighbouring steps: noise of 0.3 steps gives 0.9e-3 of them where the level lies half-way
    /// between two, 4.6e-3 where it lies on one.
    few_wide: f64 = 1e-3;
    /// Noise then assumed, in steps: the scatter of two values determines where between them the
    /// level lies, but hardly the noise, 0 to 0.28. The standard deviation √r of its repeated
    /// rounding is 0.146 steps, half of that without noise and three times that at 0.28.
    two_valued: f64 = 0.15;
}

/// Pixels either side of the edge that are looked at: 3.6 blurs and 1.25 px at a blur of 6 px.
const REACH: i32 = 24;

/// Mean square of the rounding error that repeats, for noise of standard deviation `sd`, in steps²
/// (both in steps of the grey scale).
pub(crate) fn repeated_variance(sd: f64) -> f64 {
    // Below the place where two borders between counts meet in one variable, σ² + 1/12 − r is the
    // mean of Φ(1 − Φ): σ/√π exactly.
    if sd < 0.2 {
        return 1.0 / 12.0 + sd * sd - sd / std::f64::consts::PI.sqrt();
    }
    let term = |k2: f64| {
        (-4.0 * std::f64::consts::PI.powi(2) * k2 * sd * sd).exp() / (2.0 * std::f64::consts::PI.powi(2) * k2)
    };
    term(1.0) + term(4.0)
}

/// Standard deviation of the noise behind rounded grey values that scatter with a variance, over
/// all places between two counts, both in steps of the grey scale: σ² + 1/12 − r(σ) = variance.
pub(crate) fn noise_behind(variance: f64) -> f64 {
    let dithered = RoundingLimits::get().dithered;
    if variance > dithered * dithered + 1.0 / 12.0 {
        return (variance - 1.0 / 12.0).sqrt();
    }
    let (mut low, mut high) = (0.0, dithered);
    for _ in 0..24 {
        let middle: f64 = 0.5 * (low + high);
        if middle * middle + 1.0 / 12.0 - repeated_variance(middle) < variance {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// One side of a quantised frame.
pub(crate) struct RoundedSide<'a> {
    /// The edge-spread function fitted, and its blur, px.
    pub(crate) shape: &'a EdgeSpreadFunction,
    pub(crate) sigma: f64,
    /// −1 where the light lies above the edge, else 1.
    pub(crate) sign: f64,
    /// Contrast in steps of the grey scale.
    pub(crate) contrast: f64,
    /// Standard deviation of the noise in shadow and light, in steps.
    pub(crate) noise: [f64; 2],
    /// Steps over which the levels of shadow and light run along the columns that they are pooled
    /// over.
    pub(crate) level_runs: [f64; 2],
    /// Whether the other edge has the same levels, and so the same error of them.
    pub(crate) alike: bool,
}

/// Sums over the pixels of an edge.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// Share of the repeated rounding in the variance of the place.
    share: f64,
    /// Derivatives of the place by the levels of shadow and light, px a step.
    by_level: [f64; 2],
    /// Variance of the place by what rounding does to the blur, px².
    by_blur: f64,
    steepest: f64,
    count: f64,
}

impl RoundedSide<'_> {
    /// Whether rounding repeats in this frame at all.
    pub(crate) fn repeats(noise: [f64; 2]) -> bool {
        let dithered = RoundingLimits::get().dithered;
        noise.iter().any(|sd| *sd < dithered)
    }

    /// Moves the repeating variance from the edges' own to their shared uncertainty; returns the
    /// standard uncertainty that repeats, px.
    pub(crate) fn state(&self, line: &mut [Edge]) -> f64 {
        let sums = self.sums(line);
        if !(sums.count > 0.0) {
            return 0.0;
        }
        let of = |sum: f64| sum / sums.count;
        let met = 1.0 + self.contrast * sums.steepest * rows_swept(line);
        let share = of(sums.share).max(self.shown(line)) / met;
        let levels = [0, 1].map(|k| {
            let r = repeated_variance(self.noise[k]) / (1.0 + self.level_runs[k]);
            of(sums.by_level[k]).powi(2) * if self.alike { 2.0 * r } else { r }
        });
        let rest = levels.iter().sum::<f64>() + (of(sums.by_blur) / met).max(0.0);
        let (mut total, mut count) = (0.0, 0.0);
        let left = (1.0 - share).max(0.0).sqrt() as f32;
        for edge in line.iter_mut().filter(|e| e.is_usable()) {
            let moved = share.min(1.0) * f64::from(edge.u_own_px).powi(2) + rest;
            edge.u_own_px *= left;
            edge.u_shared_px = (edge.u_shared_px * edge.u_shared_px + moved as f32).sqrt();
            (total, count) = (total + moved, count + 1.0);
        }
        (total / f64::max(count, 1.0)).sqrt()
    }

    /// Fraction of repetition by the edges themselves: neighbours that repeat their rounding differ
    /// by less than their standard uncertainty.
    /// The scatter of the grey values may mislead: at a level half-way between two counts the least
    /// noise makes them differ.
    fn shown(&self, line: &[Edge]) -> f64 {
        let pairs = line.windows(2).filter(|pair| pair.iter().all(Edge::is_usable));
        let (mut square, mut own) = (0.0, 0.0);
        for pair in pairs {
            let variance = pair.iter().map(|e| f64::from(e.u_own_px).powi(2)).sum::<f64>();
            // A step along the part is not noise.
            square += (pair[1].row_px - pair[0].row_px).powi(2).min(25.0 * variance);
            own += variance;
        }
        let share = if own > 0.0 { 1.0 - square / own } else { 0.0 };
        if share > RoundingLimits::get().shown { share } else { 0.0 }
    }

    fn sums(&self, line: &[Edge]) -> Sums {
        let mut sums = Sums::default();
        let mut samples = [EdgeSample::default(); 2 * REACH as usize + 1];
        let step = line.len().div_ceil(RoundingLimits::get().looked_at).max(1);
        for edge in line.iter().step_by(step).filter(|e| e.is_usable()) {
            let phase = self.sign * (edge.row_px - edge.row_px.round());
            self.shape.samples(f64::from(-REACH), phase, self.sigma, &mut samples);
            self.add(&samples, &mut sums);
        }
        sums
    }

    /// Adds an edge: scoring with variances v = σ_k² + 1/12.
    fn add(&self, samples: &[EdgeSample], sums: &mut Sums) {
        let [dark, light] = self.noise.map(|sd| sd * sd);
        let (mut xx, mut xs, mut ss, mut repeated, mut by) = (0.0, 0.0, 0.0, 0.0, [0.0; 2]);
        for s in samples {
            let noise = dark + (light - dark) * s.value;
            let weight = 1.0 / (noise + 1.0 / 12.0);
            let r = repeated_variance(noise.max(0.0).sqrt());
            xx += weight * s.by_position.powi(2);
            xs += weight * s.by_position * s.by_sigma;
            ss += weight * s.by_sigma.powi(2);
            repeated += (weight * s.by_position).powi(2) * r;
            by[0] += weight * s.by_position * (1.0 - s.value);
            by[1] += weight * s.by_position * s.value;
            sums.steepest = sums.steepest.max(s.by_position.abs());
        }
        if !(xx > 0.0 && self.contrast > 0.0) {
            return;
        }
        let share = repeated / xx;
        sums.share += share;
        for (sum, by) in sums.by_level.iter_mut().zip(by) {
            *sum += by / xx / self.contrast;
        }
        let information = (ss - xs * xs / xx).max(1e-12) * self.contrast.powi(2);
        sums.by_blur += (xs / xx).powi(2) * share / information;
        sums.count += 1.0;
    }
}

/// Rows that an edge runs over within a local mean, px, on the mean over the line.
pub(crate) fn rows_swept(line: &[Edge]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for block in line.chunks(RoundingLimits::get().local_columns) {
        let mut usable = block.iter().filter(|e| e.is_usable()).map(|e| e.row_px);
        if let (Some(first), Some(last)) = (usable.next(), usable.next_back()) {
            (sum, count) = (sum + (last - first).abs(), count + 1.0);
        }
    }
    sum / f64::max(count, 1.0)
}

/// Noise behind rounded grey values that scatter so, in steps of the grey scale.
pub(crate) fn noise_in_steps(spread: Spread, step: f64) -> f64 {
    let sd = noise_behind(spread.variance().unwrap_or(f64::INFINITY) / (step * step));
    let RoundingLimits { few_wide, two_valued, .. } = *RoundingLimits::get();
    if spread.wide_share() < few_wide { sd.min(two_valued) } else { sd }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean and variance of a rounded normal variable by its distribution function.
    fn rounded(mean: f64, sd: f64) -> (f64, f64) {
        let (mut sum, mut square) = (0.0, 0.0);
        for k in -12..=12 {
            let k = f64::from(k);
            let cdf = |x: f64| crate::numerics::distributions::phi_cdf((x - mean) / sd);
            let p = cdf(k + 0.5) - cdf(k - 0.5);
            (sum, square) = (sum + p * k, square + p * k * k);
        }
        (sum, square - sum * sum)
    }

    #[test]
    fn the_repeated_part_is_that_of_a_rounded_normal_variable() {
        for sd in [0.03, 0.1, 0.2, 0.3, 0.4] {
            let n = 4000;
            let (mut bias, mut variance) = (0.0, 0.0);
            for i in 0..n {
                let mean = (f64::from(i) + 0.5) / f64::from(n);
                let (m, v) = rounded(mean, sd);
                bias += (m - mean).powi(2) / f64::from(n);
                variance += v / f64::from(n);
            }
            assert!((bias - repeated_variance(sd)).abs() < 2e-5, "{sd}: {bias} {}", repeated_variance(sd));
            // Together always σ² + 1/12.
            assert!((bias + variance - sd * sd - 1.0 / 12.0).abs() < 2e-5, "{sd}");
            assert!((noise_behind(variance) - sd).abs() < 0.01, "{sd} {}", noise_behind(variance));
        }
        assert!((repeated_variance(0.0) - 1.0 / 12.0).abs() < 1e-12 && repeated_variance(0.55) < 1e-6);
        assert!(noise_behind(0.0) == 0.0 && (noise_behind(1.0) - (11.0_f64 / 12.0).sqrt()).abs() < 1e-12);
    }
}
