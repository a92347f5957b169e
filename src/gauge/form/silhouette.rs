//! From the support function, which silhouettes give, to the profile.
//!
//! A silhouette shows h(α) = max over the body of p·n(α): the distance of the tangent with normal
//! n(α) = (cos α, sin α). h is not the polar radius: for r = R + a·cos kθ, h exceeds r by r'²/2R ≤
//! (ka)²/2R to leading order, and equals it only while k²a ≪ R ([`hull_limit`]). The tangents'
//! envelope (the polar dual of 1/h) gives the boundary of the convex hull back exactly:
//!
//! ```text
//! p(α) = h·n + h'·n'        radius of curvature ϱ(α) = h + h''  (≥ 0 for a convex body)
//! r = √(h² + h'²)           θ = α + atan(h'/h)
//! ```
//!
//! Hollows between lobes with k²a > R stay unseen. The derivatives amplify noise by k and k², so
//! the support function is low-pass filtered first, and ϱ < 0 is refused.

use glam::DVec2;
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;

use super::error::FormError;
use super::harmonics::spectrum;
use super::profile_filter::{Cutoff, gaussian_closed};

/// A point of the hull's boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HullPoint {
    /// Position, in the support function's unit.
    pub position: DVec2,
    /// Direction of its tangent's normal α, radians.
    pub normal_angle: f64,
    /// Radius of curvature there.
    pub curvature_radius: f64,
}

/// How far support function and profile of one lobe pattern differ: k²a/R (convex only below about
/// 1, and h ≈ r only far below), and the greatest excess (ka)²/2R of h over r to leading order, in
/// the unit of `amplitude`.
#[cfg(test)]
pub(crate) fn hull_limit(lobes: f64, amplitude: f64, radius: f64) -> (f64, f64) {
    (lobes * lobes * amplitude / radius, (lobes * amplitude).powi(2) / (2.0 * radius))
}

/// A trigonometric polynomial.
struct Series {
    mean: f64,
    terms: Vec<Complex<f64>>,
}

impl Series {
    /// Interpolates even samples after the filter; without the Nyquist term, whose phase is
    /// unknown.
    fn new(support: &[f64], cutoff: Cutoff) -> Self {
        let filtered = gaussian_closed(support, cutoff);
        let mean = filtered.iter().sum::<f64>() / filtered.len() as f64;
        let shape: Vec<f64> = filtered.iter().map(|h| h - mean).collect();
        let mut terms = spectrum(&shape);
        terms.truncate(support.len().div_ceil(2));
        // Beyond four cutoffs less than 2^-16 passes; 2^-64 is below rounding.
        terms.truncate(((8.0 * cutoff.undulations()).ceil() as usize).saturating_add(1));
        Self { mean, terms }
    }

    /// h, h', h''.
    fn at(&self, angle: f64) -> [f64; 3] {
        let turn = Complex::from_polar(1.0, angle);
        let mut power = Complex::new(1.0, 0.0);
        let mut sum = [self.mean, 0.0, 0.0];
        for (k, term) in self.terms.iter().enumerate() {
            let value = term * power;
            let k = k as f64;
            sum[0] += value.re;
            sum[1] -= k * value.im;
            sum[2] -= k * k * value.re;
            power *= turn;
        }
        sum
    }

    fn hull_point(&self, angle: f64) -> Result<HullPoint, FormError> {
        let [h, slope, bend] = self.at(angle);
        let curvature_radius = h + bend;
        if curvature_radius < 0.0 {
            return Err(FormError::NotConvex { angle_deg: angle.to_degrees(), curvature_radius });
        }
        let normal = DVec2::from_angle(angle);
        Ok(HullPoint { position: normal * h + normal.perp() * slope, normal_angle: angle, curvature_radius })
    }

    /// The normal angle whose point stands at polar angle θ, by Newton: dθ/dα = h·ϱ/r².
    fn normal_at(&self, polar: f64) -> f64 {
        let mut angle = polar;
        for _ in 0..60 {
            let [h, slope, bend] = self.at(angle);
            let miss = angle + slope.atan2(h) - polar;
            let rate = h * (h + bend) / (h * h + slope * slope);
            let step = miss / rate.max(0.25);
            angle -= step;
            if step.abs() < 1e-15 {
                break;
            }
        }
        angle
    }
}

fn check(support: &[f64]) -> Result<(), FormError> {
    if support.len() < 8 {
        return Err(FormError::TooFew { feature: "support function", found: support.len(), needed: 8 });
    }
    if let Some(index) = support.iter().position(|h| !h.is_finite()) {
        return Err(FormError::NotFinite { index });
    }
    match support.iter().copied().find(|h| *h <= 0.0) {
        Some(value) => {
            let right = "above 0: measure it from a point inside the body";
            Err(FormError::Argument { name: "support function", value, right })
        }
        None => Ok(()),
    }
}

/// Boundary of the convex hull at the samples' own tangents, from h at n even angles α_i = i·2π/n.
///
/// # Errors
/// Too few, non-finite or non-positive samples; a support function that is not convex after the
/// filter.
pub(crate) fn hull_from_support(support: &[f64], cutoff: Cutoff) -> Result<Vec<HullPoint>, FormError> {
    check(support)?;
    let series = Series::new(support, cutoff);
    let n = support.len();
    (0..n).map(|i| series.hull_point(TAU * i as f64 / n as f64)).collect()
}

/// Polar profile r(θ_i) of the convex hull about the origin at n even polar angles θ_i = i·2π/n.
///
/// # Errors
/// As [`hull_from_support`].
pub(crate) fn polar_profile(support: &[f64], cutoff: Cutoff) -> Result<Vec<f64>, FormError> {
    hull_from_support(support, cutoff)?;
    let series = Series::new(support, cutoff);
    let n = support.len();
    (0..n)
        .map(|i| Ok(series.hull_point(series.normal_at(TAU * i as f64 / n as f64))?.position.length()))
        .collect()
}
