//! The edge of a head's nominal optics as its pixels have it: at a distance from the plane of
//! focus, and smeared by motion.
//!
//! ```text
//! E(d) = (F ⊗ box of a pixel ⊗ box of the path during the exposure)(d)
//! ```
//!
//! F is the edge-spread function of the optics, d the distance of the pixel's centre from the
//! geometric edge into the light, px. Both boxes are taken of F sampled 64 times a pixel by the
//! trapezoidal rule: the error is at most (1/64)²/12 of F's steepest slope a pixel, 4e-5 of the
//! contrast at a blur of 0.25 px, and the same in the edge and in the model fitted to it.

use crate::job::NominalEdge;
use crate::render::RenderError;
use crate::render::settings::{Esf, Optics};

/// Samples a pixel.
pub(super) const PER_PX: usize = 64;

/// A head's optics before a part.
#[derive(Clone, Debug)]
pub(super) struct EdgeOptics {
    /// Nominal optics.
    pub(super) optics: Optics,
    /// Nominal size of a pixel on the part, mm.
    pub(super) pixel_mm: f64,
    /// Radius of the part, mm.
    pub(super) radius_mm: f64,
}

impl EdgeOptics {
    /// The edge with the axis `y_mm` in front of the plane of focus.
    ///
    /// # Errors
    /// Optics whose table cannot be computed at that distance.
    pub(super) fn at(&self, y_mm: f64) -> Result<OpticalEdge, RenderError> {
        let (mut optics, mut depth_mm) = (self.optics.clone(), y_mm);
        if let Esf::PartiallyCoherent(p) = &mut optics.esf {
            // One table at this distance in place of a stack up to it.
            (p.defocus_mm, depth_mm) = (p.defocus_mm + y_mm, 0.0);
        }
        if let Esf::Cylinder(c) = &mut optics.esf {
            (c.defocus_mm, depth_mm) = (c.defocus_mm + y_mm, 0.0);
        }
        let edge = NominalEdge::new(&optics, self.pixel_mm, self.radius_mm, depth_mm)?;
        Ok(OpticalEdge { edge, um_per_px: 1e3 * self.pixel_mm })
    }
}

/// An edge-spread function before the pixel.
pub(super) struct OpticalEdge {
    edge: NominalEdge,
    um_per_px: f64,
}

impl OpticalEdge {
    /// Light at a distance into the light, px.
    pub(super) fn light(&self, distance_px: f64) -> f64 {
        self.edge.light(distance_px * self.um_per_px)
    }

    /// The edge over pixels up to `half_px` either side, its distances stretched by `scale`.
    pub(super) fn over_pixels(&self, half_px: usize, scale: f64, smear_px: f64) -> PixelEdge {
        PixelEdge::of(half_px, smear_px, |d| self.light(d / scale))
    }

    /// Distance between 10 % and 90 % of the light, px: first crossings from the shadow, before the
    /// pixel. `None` where they lie farther apart than the window is long.
    pub(super) fn width_10_90_px(&self, half_px: usize) -> Option<f64> {
        let at = |i: usize| i as f64 / PER_PX as f64 - half_px as f64;
        let crossing = |level: f64| {
            let k = (1..=2 * half_px * PER_PX).find(|k| self.light(at(*k)) >= level)?;
            let (below, above) = (self.light(at(k - 1)), self.light(at(k)));
            (below < level).then(|| at(k - 1) + (level - below) / (above - below) / PER_PX as f64)
        };
        Some(crossing(0.9)? - crossing(0.1)?)
    }
}

/// Light on a pixel over the distance of its centre from the edge, 64 samples a pixel.
#[derive(Clone, Debug)]
pub(super) struct PixelEdge {
    half_px: usize,
    light: Vec<f64>,
}

impl PixelEdge {
    /// Of an edge-spread function, light over px.
    pub(super) fn of(half_px: usize, smear_px: f64, light: impl Fn(f64) -> f64) -> Self {
        let margin = (0.5 * (1.0 + smear_px)).ceil() as usize + 1;
        let reach = half_px + margin;
        let at = |i: usize| light(i as f64 / PER_PX as f64 - reach as f64);
        let point: Vec<f64> = (0..=2 * reach * PER_PX).map(at).collect();
        let mut over = boxed(&point, PER_PX as f64);
        if smear_px > 0.0 {
            over = boxed(&over, smear_px * PER_PX as f64);
        }
        let first = margin * PER_PX;
        Self { half_px, light: over[first..=first + 2 * half_px * PER_PX].to_vec() }
    }

    /// Number of samples.
    pub(super) fn samples(&self) -> usize {
        self.light.len()
    }

    /// Distance of a sample, px.
    pub(super) fn distance_px(&self, sample: usize) -> f64 {
        sample as f64 / PER_PX as f64 - self.half_px as f64
    }

    /// Light at a sample.
    pub(super) fn value(&self, sample: usize) -> f64 {
        self.light[sample]
    }

    /// dE/dd at a sample, 1/px.
    pub(super) fn slope(&self, sample: usize) -> f64 {
        let last = self.light.len() - 1;
        let (before, after) = (sample.saturating_sub(1), (sample + 1).min(last));
        (self.light[after] - self.light[before]) * PER_PX as f64 / (after - before) as f64
    }

    /// Light and its slope at a distance, px: the cubic through values and slopes of the samples.
    pub(super) fn at(&self, distance_px: f64) -> (f64, f64) {
        let last = self.light.len() - 1;
        let place = ((distance_px + self.half_px as f64) * PER_PX as f64).clamp(0.0, last as f64);
        let k = (place as usize).min(last - 1);
        let t = place - k as f64;
        let step = 1.0 / PER_PX as f64;
        let (a, b) = (self.light[k], self.light[k + 1]);
        let (da, db) = (step * self.slope(k), step * self.slope(k + 1));
        let (c2, c3) = (3.0 * (b - a) - 2.0 * da - db, 2.0 * (a - b) + da + db);
        (a + t * (da + t * (c2 + t * c3)), (da + t * (2.0 * c2 + 3.0 * t * c3)) / step)
    }
}

/// The running mean of samples over a width, in samples; the ends continue level.
fn boxed(values: &[f64], width: f64) -> Vec<f64> {
    let last = values.len() - 1;
    let mut integral = vec![0.0; values.len()];
    for k in 1..values.len() {
        integral[k] = integral[k - 1] + 0.5 * (values[k - 1] + values[k]);
    }
    let up_to = |place: f64| {
        if place <= 0.0 {
            return place * values[0];
        }
        if place >= last as f64 {
            return integral[last] + (place - last as f64) * values[last];
        }
        let (k, t) = (place as usize, place.fract());
        integral[k] + t * values[k] + 0.5 * t * t * (values[k + 1] - values[k])
    };
    let mean = |i: usize| (up_to(i as f64 + 0.5 * width) - up_to(i as f64 - 0.5 * width)) / width;
    (0..values.len()).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::distributions::{phi_cdf, phi_pdf};

    /// Closed form of the Gaussian edge over a box: G(d + w/2) − G(d − w/2), G = uΦ + σφ.
    fn over_a_box(d: f64, sigma: f64, width: f64) -> f64 {
        let g = |u: f64| u * phi_cdf(u / sigma) + sigma * phi_pdf(u / sigma);
        (g(d + 0.5 * width) - g(d - 0.5 * width)) / width
    }

    #[test]
    fn pixels_are_the_closed_form_of_a_gaussian_edge() {
        let edge = PixelEdge::of(12, 0.0, |d| phi_cdf(d / 0.8));
        for i in (64..edge.samples() - 64).step_by(37) {
            let d = edge.distance_px(i);
            assert!((edge.value(i) - over_a_box(d, 0.8, 1.0)).abs() < 1e-5, "{d}");
        }
        let (light, slope) = edge.at(0.123);
        assert!((light - over_a_box(0.123, 0.8, 1.0)).abs() < 1e-5);
        let h = 1e-4;
        let wanted = (over_a_box(0.123 + h, 0.8, 1.0) - over_a_box(0.123 - h, 0.8, 1.0)) / (2.0 * h);
        assert!((slope - wanted).abs() < 1e-4, "{slope} {wanted}");
    }

    /// A path during the exposure adds the variance s²/12 of a box to that of the line spread.
    #[test]
    fn a_smear_adds_its_variance() {
        let variance = |edge: &PixelEdge| {
            let sum = (1..edge.samples() - 1).map(|i| (edge.slope(i), edge.distance_px(i)));
            sum.fold(0.0, |v, (slope, d)| v + slope * d * d) / PER_PX as f64
        };
        let (still, smeared) =
            (PixelEdge::of(20, 0.0, |d| phi_cdf(d / 1.1)), PixelEdge::of(20, 5.3, |d| phi_cdf(d / 1.1)));
        let added = variance(&smeared) - variance(&still);
        assert!((added - 5.3 * 5.3 / 12.0).abs() < 2e-3, "{added}");
        assert!((variance(&still) - 1.1 * 1.1 - 1.0 / 12.0).abs() < 2e-3);
    }
}
