//! The pixel-integrated Gaussian edge.
//!
//! A step up at x0, blurred by a Gaussian of standard deviation σ and averaged over the pixel's own
//! area, reads in pixel k (levels 0 and 1)
//!
//! ```text
//! E_k(x0) = G(k + 1/2 − x0) − G(k − 1/2 − x0)      G(u) = u·Φ(u/σ) + σ·φ(u/σ)
//! ∂E/∂x0  = −[Φ((k + 1/2 − x0)/σ) − Φ((k − 1/2 − x0)/σ)]
//! ∂E/∂σ   = φ((k + 1/2 − x0)/σ) − φ((k − 1/2 − x0)/σ)
//! ```
//!
//! Valid for σ ≥ 0.2 px and edges that cross the scan line at any small angle; for a slope t = tan
//! β along the shaft the blur seen along the column is σ² (1 + t²) + t²/12 ([`column_sigma`]).

use crate::numerics::distributions::{phi_cdf, phi_pdf};

/// Value and derivatives of the unit edge in one pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct EdgeSample {
    /// E, 0..=1.
    pub(crate) value: f64,
    /// ∂E/∂x0, per px (negative: the edge moves away into the light).
    pub(crate) by_position: f64,
    /// ∂E/∂σ, per px.
    pub(crate) by_sigma: f64,
}

impl EdgeSample {
    /// The pixel between two borders, each with G, Φ and ∂G/∂σ.
    #[inline(always)]
    pub(crate) fn between(left: &[f64; 3], right: &[f64; 3]) -> Self {
        Self { value: right[0] - left[0], by_position: left[1] - right[1], by_sigma: right[2] - left[2] }
    }
}

/// G, Φ and φ = ∂G/∂σ at a border of pixels `u` px from the edge.
pub(crate) fn border(u: f64, sigma: f64) -> [f64; 3] {
    let t = u / sigma;
    let (cdf, pdf) = (phi_cdf(t), phi_pdf(t));
    [u * cdf + sigma * pdf, cdf, pdf]
}

/// Evaluates pixels `first..first + out.len()` of a unit edge at `x0`, sharing the work at the
/// pixels' borders.
pub(crate) fn edge_samples(first: f64, x0: f64, sigma: f64, out: &mut [EdgeSample]) {
    let mut left = border(first - 0.5 - x0, sigma);
    for (k, sample) in out.iter_mut().enumerate() {
        let right = border(first + k as f64 + 0.5 - x0, sigma);
        *sample = EdgeSample::between(&left, &right);
        left = right;
    }
}

/// Blur along the column of an edge with slope `slope` (rows per column), px.
pub(crate) fn column_sigma(sigma: f64, slope: f64) -> f64 {
    let t2 = slope * slope;
    (sigma * sigma * (1.0 + t2) + t2 / 12.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The pixel integral by brute force: midpoint rule over the pixel.
    fn by_quadrature(k: f64, x0: f64, sigma: f64) -> f64 {
        let n = 20_000;
        (0..n).map(|i| phi_cdf((k - 0.5 + (f64::from(i) + 0.5) / f64::from(n) - x0) / sigma)).sum::<f64>()
            / f64::from(n)
    }

    #[test]
    fn samples_are_the_pixel_integral_and_its_derivatives() {
        for sigma in [0.3, 0.8, 2.0] {
            for x0 in [-0.4, 0.0, 0.27] {
                let mut out = [EdgeSample::default(); 9];
                let (mut up, mut down, mut wide, mut narrow) = (out, out, out, out);
                edge_samples(-4.0, x0, sigma, &mut out);
                let h = 1e-5;
                edge_samples(-4.0, x0 + h, sigma, &mut up);
                edge_samples(-4.0, x0 - h, sigma, &mut down);
                edge_samples(-4.0, x0, sigma + h, &mut wide);
                edge_samples(-4.0, x0, sigma - h, &mut narrow);
                for k in 0..9 {
                    let expected = by_quadrature(k as f64 - 4.0, x0, sigma);
                    assert!((out[k].value - expected).abs() < 1e-8);
                    let dx = (up[k].value - down[k].value) / (2.0 * h);
                    let ds = (wide[k].value - narrow[k].value) / (2.0 * h);
                    assert!((out[k].by_position - dx).abs() < 1e-8, "{} {dx}", out[k].by_position);
                    assert!((out[k].by_sigma - ds).abs() < 1e-8);
                }
            }
        }
    }
}
