//! The Gaussian edge averaged over a square pixel that it crosses at any angle.
//!
//! A straight edge with normal at angle θ, blurred by σ: seen along its normal the pixel's square
//! is the convolution of two boxes of widths a = |cos θ| and b = |sin θ|. With H'' = Φ(u/σ), that
//! is H(u) = ½[(u² + σ²)·Φ + u·σ·φ], the pixel at distance d on the light's side reads
//!
//! ```text
//! E(d) = [H(d + (a+b)/2) − H(d + (a−b)/2) − H(d − (a−b)/2) + H(d − (a+b)/2)]/(ab)
//! ∂E/∂d: G = H' in place of H        ∂E/∂σ: σ·Φ in place of H (heat equation)
//! ```
//!
//! Where one width vanishes the narrow box is put into the blur, σ² + b²/12, exact to b⁴/σ⁴/2880.

use crate::numerics::distributions::{phi_cdf, phi_pdf};
use crate::numerics::normal_table::NormalTable;

/// Value and derivatives of the unit edge in one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sample {
    /// E, 0 in the shadow to 1 in the light.
    pub(super) value: f64,
    /// ∂E/∂d, per px.
    pub(super) by_distance: f64,
    /// ∂E/∂σ, per px.
    pub(super) by_sigma: f64,
}

/// The edge in a pixel whose centre lies `d` px from it, normal direction (cos θ, sin θ); Φ and φ
/// from a table, to 1e-9, of which the differences over a narrow box make 1e-6 at most.
pub(super) fn square_edge(d: f64, cos: f64, sin: f64, sigma: f64) -> Sample {
    let table = NormalTable::get();
    edge(&|t| table.at(t), d, (cos, sin), sigma)
}

/// The same without a table, at normal (cos θ, sin θ).
pub(super) fn exact_edge(d: f64, normal: (f64, f64), sigma: f64) -> Sample {
    edge(&|t| [phi_cdf(t), phi_pdf(t)], d, normal, sigma)
}

/// The edge by a function that gives Φ and φ.
fn edge(normal: &impl Fn(f64) -> [f64; 2], d: f64, (cos, sin): (f64, f64), sigma: f64) -> Sample {
    let (a, b) = (cos.abs().max(sin.abs()), cos.abs().min(sin.abs()));
    if b < 0.05 {
        return box_edge(normal, d, a, [(sigma * sigma + b * b / 12.0).sqrt(), sigma]);
    }
    let (outer, inner) = (0.5 * (a + b), 0.5 * (a - b));
    let corners = [(outer, 1.0), (inner, -1.0), (-inner, -1.0), (-outer, 1.0)];
    let mut sum = [0.0; 3];
    for (shift, sign) in corners {
        let u = d + shift;
        let [cdf, pdf] = normal(u / sigma);
        // Φ, G = ∫Φ and H = ∫G of u at blur σ
        let g = u * cdf + sigma * pdf;
        let h = 0.5 * (u * g + sigma * sigma * cdf);
        sum[0] += sign * cdf;
        sum[1] += sign * g;
        sum[2] += sign * h;
    }
    let per_area = (a * b).recip();
    Sample { value: sum[2] * per_area, by_distance: sum[1] * per_area, by_sigma: sigma * sum[0] * per_area }
}

/// The same with one box of width a and blur s; the derivative is by the lens's own σ: dE/dσ =
/// (σ/s)·dE/ds.
fn box_edge(normal: &impl Fn(f64) -> [f64; 2], d: f64, a: f64, [s, sigma]: [f64; 2]) -> Sample {
    let (u, v) = (d + 0.5 * a, d - 0.5 * a);
    let ([cdf_u, pdf_u], [cdf_v, pdf_v]) = (normal(u / s), normal(v / s));
    Sample {
        value: (u * cdf_u - v * cdf_v + s * (pdf_u - pdf_v)) / a,
        by_distance: (cdf_u - cdf_v) / a,
        by_sigma: (pdf_u - pdf_v) / a * (sigma / s),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn by_functions(d: f64, cos: f64, sin: f64, sigma: f64) -> Sample {
        exact_edge(d, (cos, sin), sigma)
    }

    #[test]
    fn the_table_is_exact_to_a_part_in_a_million() {
        for k in 0..2000 {
            let turn = 0.37 * f64::from(k);
            let (sin, cos) = turn.sin_cos();
            let (d, sigma) = (7.0 * (1.9 * turn).sin(), 0.4 + 2.0 * (0.7 * turn).cos().abs());
            let (a, b) = (square_edge(d, cos, sin, sigma), by_functions(d, cos, sin, sigma));
            let off = [a.value - b.value, a.by_distance - b.by_distance, a.by_sigma - b.by_sigma];
            assert!(off.iter().all(|o| o.abs() < 1e-6), "{d} {turn} {sigma}: {off:?}");
        }
    }

    #[test]
    fn the_edge_in_a_square_is_its_area_integral_at_every_angle() {
        let sigma = 0.6;
        let n = 400;
        for degrees in [0.0_f64, 1.0, 2.8, 3.0, 20.0, 45.0, 77.0, 90.0, 135.0, 200.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            for d in [-1.3, -0.2, 0.0, 0.7, 2.0] {
                let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n) - 0.5;
                let mut sum = 0.0;
                for i in 0..n {
                    for j in 0..n {
                        let u = d + at(i) * cos + at(j) * sin;
                        sum += phi_cdf(u / sigma);
                    }
                }
                let exact = sum / f64::from(n * n);
                let found = by_functions(d, cos, sin, sigma);
                assert!((found.value - exact).abs() < 1e-6, "{degrees} {d}: {} {exact}", found.value);
                let h = 1e-5;
                let slope = |s: Sample, t: Sample| (s.value - t.value) / (2.0 * h);
                let by_d = slope(by_functions(d + h, cos, sin, sigma), by_functions(d - h, cos, sin, sigma));
                let by_s = slope(by_functions(d, cos, sin, sigma + h), by_functions(d, cos, sin, sigma - h));
                assert!((found.by_distance - by_d).abs() < 1e-7 && (found.by_sigma - by_s).abs() < 1e-7);
            }
        }
    }
}
