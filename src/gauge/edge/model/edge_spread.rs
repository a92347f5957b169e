//! The edge-spread function that is fitted: the Gaussian, one given as a table, or one estimated
//! from the frame.
//!
//! Every one is a location-scale family. With the integral I(t) = ∫F over t = u·σ₀/σ, a step at x0
//! reads in pixel k
//!
//! ```text
//! E_k(x0) = (σ/σ₀)·[I(t(k + 1/2 − x0)) − I(t(k − 1/2 − x0))]
//! ∂E/∂x0  = F(t(k − 1/2 − x0)) − F(t(k + 1/2 − x0))
//! ∂E/∂σ   = [(I − tF)(k + 1/2 − x0) − (I − tF)(k − 1/2 − x0)]/σ₀
//! ```
//!
//! so that the pixel's own area is integrated whatever the family. σ₀ = 1/(√2π·max F′) is the
//! standard deviation of the Gaussian that is as steep; it makes the blur of all families
//! comparable.

use std::sync::Arc;

use super::gaussian::{EdgeSample, border as gaussian_border, edge_samples};
use crate::gauge::limit::limits;

limits! {
    /// Which blurs are searched, and how far an edge reaches.
    EdgeSpreadLimits = "edge_spread";
    /// Least plausible blur, px: below it one pixel holds the whole edge and does not show its
    /// width. A table has its own ([`EdgeSpreadFunction::least_sigma`]).
    least_sigma_px: f64 = 0.2;
    /// Largest plausible blur, px: the longest window of 72 px holds its reach of 30 px and four
    /// flat pixels either side.
    most_sigma_px: f64 = 8.0;
    /// Knots of a table per pixel: the cubic through I and F errs by h⁴/384·max|F‴| < 1e-6 at σ =
    /// 0.12 px.
    knots_per_px: f64 = 64.0;
    /// Distance from the edge, in σ (and 1.25 px), beyond which the tails of a table that still
    /// differs from its ends by more than `tail` are left out of the fit: they would need windows
    /// as long as the field is high.
    farthest: f64 = 12.0;
    /// Light, as a multiple of the bright field, beyond which a table is the shadow of coherent
    /// light without a lens: its first ring has 1.37, that of the sharpest lens in coherent light
    /// 1.18 (Fresnel and sine integrals).
    ringed: f64 = 1.25;
    /// Pixels either side of the edge that carry information in a pattern of rings: what the
    /// longest windows of 256 px hold beside 24 flat ones.
    ringed_reach_px: f64 = 96.0;
    /// Difference of the light from 0 or 1, as a share of the bright field, that counts as flat: a
    /// level off by that moves an edge by half of it over the slope, .001·√(2π) = .0025 σ.
    tail: f64 = 2e-3;
    /// Pixels either side of the edge that carry information on its place, in σ, for the Gaussian:
    /// those beyond hold erfc(3.6) = 4e-7 of ∫(∂E/∂x)².
    gaussian_reach: f64 = 3.6;
    /// Places of an edge within a pixel over which a mean is taken, evenly spaced: the mean is free
    /// of the first seven harmonics of the phase.
    phases: u32 = 8;
}

/// An edge-spread function as a table of its values and their integral over ±`reach` px; 0 and 1
/// beyond.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TabulatedEsf {
    reach: f64,
    knots: Vec<Knot>,
    /// σ₀, px.
    sigma: f64,
    /// Mean of the line-spread function, px.
    centroid: f64,
    /// Distance from the edge up to which the function differs from its ends, in σ₀.
    tail: f64,
    /// Whether it has the rings of coherent light without a lens.
    ringed: bool,
}

/// An edge-spread function at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Knot {
    /// I, px.
    pub(crate) integral: f64,
    /// F.
    pub(crate) value: f64,
}

impl TabulatedEsf {
    /// Tabulates a function that is 0 before −`reach` px and 1 after `reach` px.
    pub(crate) fn new(reach: f64, f: impl Fn(f64) -> f64) -> Self {
        let count = (2.0 * reach * EdgeSpreadLimits::get().knots_per_px).ceil() as usize;
        let step = 2.0 * reach / count as f64;
        let at = |k: f64| f(-reach + k * step);
        let value: Vec<f64> = (0..=count).map(|k| at(k as f64)).collect();
        let mut knots = vec![Knot { integral: 0.0, value: value[0] }; count + 1];
        for k in 0..count {
            let middle = at(k as f64 + 0.5);
            let integral = knots[k].integral + step / 6.0 * (value[k] + 4.0 * middle + value[k + 1]);
            knots[k + 1] = Knot { integral, value: value[k + 1] };
        }
        Self::from_knots(reach, knots)
    }

    /// From values and integrals at equidistant knots over ±`reach` px.
    pub(crate) fn from_knots(reach: f64, knots: Vec<Knot>) -> Self {
        let limits = EdgeSpreadLimits::get();
        let count = knots.len() - 1;
        let step = 2.0 * reach / count as f64;
        let steepest = knots.windows(2).map(|w| w[1].value - w[0].value).fold(0.0, f64::max) / step;
        let ringed = knots.iter().any(|k| k.value > limits.ringed);
        let sigma = 1.0 / (steepest * (2.0 * std::f64::consts::PI).sqrt()).clamp(1e-2, 8.0);
        let centroid = reach - knots[count].integral;
        let away = |k: usize| (-reach + k as f64 * step).abs();
        let far = |k: &usize| {
            let end = if 2 * k < count { 0.0 } else { 1.0 };
            (knots[*k].value - end).abs() > limits.tail
        };
        let tail = (0..=count).filter(far).map(away).fold(0.0, f64::max) / sigma;
        Self { reach, knots, sigma, centroid, tail: tail.clamp(2.0, limits.farthest), ringed }
    }

    /// As learnt from a frame beside a Gaussian of `sigma` px, whose tails the deviation exceeds up
    /// to `far_px`.
    pub(crate) fn learnt(reach: f64, knots: Vec<Knot>, sigma: f64, centroid: f64, far_px: f64) -> Self {
        let limits = EdgeSpreadLimits::get();
        let tail = (far_px / sigma).clamp(limits.gaussian_reach, limits.farthest);
        Self { reach, knots, sigma, centroid, tail, ringed: false }
    }

    /// I and F at `t` px.
    fn at(&self, t: f64) -> (f64, f64) {
        let count = self.knots.len() - 1;
        if t <= -self.reach {
            return (0.0, 0.0);
        }
        if t >= self.reach {
            return (self.knots[count].integral + t - self.reach, 1.0);
        }
        let step = 2.0 * self.reach / count as f64;
        let place = (t + self.reach) / step;
        let k = (place as usize).min(count - 1);
        let s = place - k as f64;
        let (left, right) = (self.knots[k], self.knots[k + 1]);
        let (a, b) = (left.integral, right.integral);
        let (da, db) = (step * left.value, step * right.value);
        let (c2, c3) = (3.0 * (b - a) - 2.0 * da - db, 2.0 * (a - b) + da + db);
        (a + s * (da + s * (c2 + s * c3)), (da + s * (2.0 * c2 + 3.0 * s * c3)) / step)
    }

    /// G, F and ∂G/∂σ at a border of pixels `u` px from the edge.
    fn border(&self, u: f64, sigma: f64) -> [f64; 3] {
        let scale = sigma / self.sigma;
        let t = u / scale;
        let (integral, value) = self.at(t);
        [scale * integral, value, (integral - t * value) / self.sigma]
    }

    /// Distance from a quarter of the light to half of it at a blur, px.
    fn quarter_to_half(&self, sigma: f64) -> f64 {
        let crossing = |level: f64| {
            let (mut low, mut high) = (-self.reach, self.reach);
            for _ in 0..50 {
                let middle = 0.5 * (low + high);
                if self.at(middle).1 < level { low = middle } else { high = middle }
            }
            low
        };
        (crossing(0.5) - crossing(0.25)) * sigma / self.sigma
    }

    /// σ₀, px.
    pub(crate) fn sigma(&self) -> f64 {
        self.sigma
    }
}

/// The family that is fitted.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) enum EdgeSpreadFunction {
    /// Gaussian blur.
    #[default]
    Gaussian,
    /// Any other, as a table.
    Table(Arc<TabulatedEsf>),
}

impl EdgeSpreadFunction {
    /// Evaluates pixels `first..first + out.len()` of a unit edge at `x0`.
    pub(crate) fn samples(&self, first: f64, x0: f64, sigma: f64, out: &mut [EdgeSample]) {
        let Self::Table(table) = self else { return edge_samples(first, x0, sigma, out) };
        let mut left = table.border(first - 0.5 - x0, sigma);
        for (k, sample) in out.iter_mut().enumerate() {
            let right = table.border(first + k as f64 + 0.5 - x0, sigma);
            *sample = EdgeSample::between(&left, &right);
            left = right;
        }
    }

    /// G, F and ∂G/∂σ at a border of pixels `u` px from the edge, with Φ and φ at u/σ.
    #[inline]
    pub(crate) fn border(&self, u: f64, sigma: f64, [cdf, pdf]: [f64; 2]) -> [f64; 3] {
        match self {
            Self::Gaussian => [u * cdf + sigma * pdf, cdf, pdf],
            Self::Table(table) => table.border(u, sigma),
        }
    }

    /// G, F and ∂G/∂σ at `count` equidistant borders of pixels, `per_px` to the pixel, the middle
    /// one of them on the edge.
    pub(crate) fn borders(&self, sigma: f64, per_px: u32, count: usize, out: &mut Vec<[f64; 3]>) {
        out.clear();
        let middle = count / 2;
        let u = |k: usize| (k as f64 - middle as f64) / f64::from(per_px);
        match self {
            Self::Table(table) => out.extend((0..count).map(|k| table.border(u(k), sigma))),
            // Symmetric: one half follows from the other.
            Self::Gaussian => {
                out.resize(count, [0.0; 3]);
                for k in middle..count {
                    let [integral, value, by_sigma] = gaussian_border(u(k), sigma);
                    out[k] = [integral, value, by_sigma];
                    if let Some(mirrored) = (2 * middle).checked_sub(k) {
                        out[mirrored] = [integral - u(k), 1.0 - value, by_sigma];
                    }
                }
            }
        }
    }

    /// Pixels either side of the edge that carry information on its place.
    pub(crate) fn reach(&self, sigma: f64) -> f64 {
        let limits = EdgeSpreadLimits::get();
        match self {
            Self::Gaussian => limits.gaussian_reach * sigma + 1.25,
            Self::Table(table) if table.ringed => (table.tail * sigma + 1.25).min(limits.ringed_reach_px),
            Self::Table(table) => table.tail * sigma + 1.25,
        }
    }

    /// Whether it has the rings of coherent light without a lens.
    pub(crate) fn is_ringed(&self) -> bool {
        matches!(self, Self::Table(table) if table.ringed)
    }

    /// Least blur of the search, px: a sharp edge that is given as a table may be sharper than any
    /// that is found.
    pub(crate) fn least_sigma(&self) -> f64 {
        let least = EdgeSpreadLimits::get().least_sigma_px;
        match self {
            Self::Gaussian => least,
            Self::Table(table) => least.min(0.5 * table.sigma),
        }
    }

    /// Largest blur that is accepted, px.
    pub(crate) fn most_sigma(&self) -> f64 {
        match self {
            Self::Table(table) if table.ringed => 2.0 * table.sigma,
            _ => EdgeSpreadLimits::get().most_sigma_px,
        }
    }

    /// Position of the edge by the area of the light relative to the fitted one, px into the light.
    pub(crate) fn centroid(&self, sigma: f64) -> f64 {
        match self {
            Self::Gaussian => 0.0,
            Self::Table(table) => table.centroid * sigma / table.sigma,
        }
    }

    /// Sum of E over a window of `width` pixels, the edge at its central one (`half`): the expected
    /// area of the light where rings reach beyond the window.
    pub(crate) fn window_sum(&self, sigma: f64, width: usize, half: usize) -> f64 {
        let mut samples = vec![EdgeSample::default(); width];
        self.samples(-(half as f64), 0.0, sigma, &mut samples);
        samples.iter().map(|s| s.value).sum()
    }

    /// Means of E over the flat ends of a window (`flat` pixels each, `width` in all) over the
    /// phases: 0 and 1 but for the tails.
    pub(crate) fn flat_ends(&self, sigma: f64, width: usize, flat: usize, half: usize) -> (f64, f64) {
        let phases = EdgeSpreadLimits::get().phases;
        if *self == Self::Gaussian {
            return (0.0, 1.0);
        }
        let mut samples = vec![EdgeSample::default(); width - 1];
        let (mut dark, mut light) = (0.0, 0.0);
        for phase in 0..phases {
            let x0 = (f64::from(phase) + 0.5) / f64::from(phases) - 0.5;
            self.samples(-(half as f64), x0, sigma, &mut samples);
            let sum = |part: &[EdgeSample]| part.iter().map(|s| s.value).sum::<f64>();
            dark += sum(&samples[..flat]);
            light += sum(&samples[width - 1 - flat..]);
        }
        let count = f64::from(phases) * flat as f64;
        (dark / count, light / count)
    }

    /// How far into the shadow of where a table that was learnt puts the edge it may truly lie, px:
    /// the geometric edge stands at half the light under incoherent light and at a quarter of it
    /// (half the amplitude) under coherent light, and a frame does not determine which.
    pub(crate) fn position_ambiguity(&self, sigma: f64) -> f64 {
        match self {
            Self::Gaussian => 0.0,
            Self::Table(table) => table.quarter_to_half(sigma),
        }
    }

    /// σ₀ of a table.
    pub(crate) fn own_sigma(&self) -> Option<f64> {
        match self {
            Self::Gaussian => None,
            Self::Table(table) => Some(table.sigma()),
        }
    }
}

#[cfg(test)]
mod tests;
