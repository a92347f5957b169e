//! The blur of a stretch of an edge, from grey values over their distance from it.
//!
//! The edge-spread function of a Gaussian, integrated over a pixel, is fitted by least squares:
//!
//! ```text
//! g(d) = a + b·E(d; σ),   E(d; σ) = σ·[I((d + ½)/σ) − I((d − ½)/σ)],   I(x) = x·Φ(x) + φ(x)
//! ```
//!
//! For every σ the levels a, b follow in closed form (variable projection); σ is where the rest is
//! least, by a golden-section search of its logarithm. Distances from edges that are placed already
//! need no phases: a level edge, whose samples are one pixel apart, is fitted as well.

use crate::numerics::distributions::{phi_cdf, phi_pdf};

/// Bins a pixel: within one the edge is straight to (1/32)²/2 of its curvature.
const PER_PX: f64 = 16.0;
/// Standard deviations on either side: beyond four the edge is level to 3e-5.
const SIGMAS: f64 = 4.0;
/// The blur found lies within this factor of the frame's: an edge that is softer still does not
/// reach its levels within the samples.
const FACTOR: f64 = 3.0;
/// Steps of the golden section: 2·ln 3·0.618³² is 4e-7 of σ.
const STEPS: usize = 32;
/// Fewest bins of a fit of three parameters that leaves some to see it fail by.
const LEAST_BINS: usize = 6;

/// Distance from an edge to which samples are of use, px, for a blur of about `near_px`.
pub(super) fn reach_px(near_px: f64) -> f64 {
    SIGMAS * near_px.max(0.0) + 1.0
}

/// Grey values in bins by their distance.
#[derive(Clone, Debug)]
pub(super) struct EdgeSamples {
    reach_px: f64,
    /// Number, sum of distances and sum of grey values of a bin.
    bins: Vec<[f64; 3]>,
}

impl EdgeSamples {
    /// No sample yet; those within `reach_px` are taken.
    pub(super) fn within(reach_px: f64) -> Self {
        let reach_px = if reach_px.is_finite() { reach_px.clamp(1.0, 1e3) } else { 1.0 };
        Self { reach_px, bins: vec![[0.0; 3]; (2.0 * reach_px * PER_PX).ceil() as usize + 1] }
    }

    /// Distance to which samples are taken, px.
    pub(super) fn reach_px(&self) -> f64 {
        self.reach_px
    }

    /// A grey value at a distance outwards, px.
    pub(super) fn push(&mut self, distance_px: f64, grey: f64) {
        let place = (distance_px + self.reach_px) * PER_PX;
        if place >= 0.0
            && let Some(bin) = self.bins.get_mut(place as usize)
        {
            *bin = [bin[0] + 1.0, bin[1] + distance_px, bin[2] + grey];
        }
    }

    /// Standard deviation of the blur without the pixel's own area, px; `None` of too few samples,
    /// or where it is not within a factor of three of `near_px`.
    pub(super) fn blur_px(&self, near_px: f64) -> Option<f64> {
        let means: Vec<[f64; 3]> =
            self.bins.iter().filter(|b| b[0] > 0.0).map(|b| [b[0], b[1] / b[0], b[2] / b[0]]).collect();
        if means.len() < LEAST_BINS || !(near_px > 0.0) {
            return None;
        }
        let (low, high) = ((near_px / FACTOR).ln(), (near_px * FACTOR).ln());
        let found = least(low, high, |ln_sigma| rest(&means, ln_sigma.exp()));
        let margin = 1e-3 * (high - low);
        (found > low + margin && found < high - margin).then(|| found.exp())
    }
}

/// The pixel-integrated Gaussian edge, 0 to 1.
fn edge(distance_px: f64, sigma_px: f64) -> f64 {
    let integral = |x: f64| x * phi_cdf(x) + phi_pdf(x);
    sigma_px * (integral((distance_px + 0.5) / sigma_px) - integral((distance_px - 0.5) / sigma_px))
}

/// Weighted sum of squares that the best levels leave.
fn rest(means: &[[f64; 3]], sigma_px: f64) -> f64 {
    let of = |m: &[f64; 3]| (m[0], edge(m[1], sigma_px), m[2]);
    let weight: f64 = means.iter().map(|m| m[0]).sum();
    let (e, g) = means.iter().map(of).fold((0.0, 0.0), |(e, g), (w, x, y)| (e + w * x, g + w * y));
    let (e, g) = (e / weight, g / weight);
    let sums = means.iter().map(of).fold([0.0; 3], |[xx, xy, yy], (w, x, y)| {
        [xx + w * (x - e).powi(2), xy + w * (x - e) * (y - g), yy + w * (y - g).powi(2)]
    });
    if sums[0] > 0.0 { sums[2] - sums[1].powi(2) / sums[0] } else { sums[2] }
}

/// Where a function with one minimum is least.
fn least(mut low: f64, mut high: f64, of: impl Fn(f64) -> f64) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let (mut a, mut b) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
    let (mut at_a, mut at_b) = (of(a), of(b));
    for _ in 0..STEPS {
        if at_a < at_b {
            (high, b, at_b) = (b, a, at_a);
            a = high - GOLDEN * (high - low);
            at_a = of(a);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = low + GOLDEN * (high - low);
            at_b = of(b);
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(sigma_px: f64, phases: &[f64], polarity: f64) -> EdgeSamples {
        let mut samples = EdgeSamples::within(reach_px(1.2));
        for phase in phases {
            for k in -8..=8 {
                let d = f64::from(k) + phase;
                // The pixel's area by 200 points, without the closed form.
                let mean: f64 =
                    (0..200).map(|i| phi_cdf((d - 0.5 + (f64::from(i) + 0.5) / 200.0) / sigma_px)).sum();
                samples.push(d, 500.0 + polarity * 400.0 * (mean / 200.0 - 0.5));
            }
        }
        samples
    }

    #[test]
    fn the_blur_drawn_is_found_at_one_phase_and_at_many() {
        for sigma_px in [0.7, 1.2, 2.0] {
            for phases in [&[0.31][..], &[0.0, 0.21, 0.48, 0.77]] {
                for polarity in [1.0, -1.0] {
                    let found = filled(sigma_px, phases, polarity).blur_px(1.2).unwrap();
                    assert!((found / sigma_px - 1.0).abs() < 2e-3, "{sigma_px} {phases:?}: {found}");
                }
            }
        }
    }

    #[test]
    fn too_few_samples_and_a_blur_far_off_give_none() {
        assert_eq!(EdgeSamples::within(5.0).blur_px(1.2), None);
        assert_eq!(filled(1.2, &[0.3], 1.0).blur_px(f64::NAN), None);
        // Ten times sharper than stated.
        assert_eq!(filled(0.12, &[0.0, 0.2, 0.4, 0.6, 0.8], 1.0).blur_px(1.2), None);
    }
}
