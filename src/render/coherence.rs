//! Image of a straight edge in partially coherent light through a circular pupil, in and out of focus.
//!
//! Every point s of the condenser's source lights the edge with a tilted plane wave; the intensities add up (Abbe, the
//! same as Hopkins' transmission cross-coefficient). With x in λ/NA, f in NA/λ, ζ the defocus in λ/NA²:
//!
//! ```text
//! u_s(x) = ∫ P(f + s) exp(iπζ|f + s|²) H(f) exp(2πi f x) df,   H(f) = ½ δ(f) + 1/(2πi f)
//! I(x)   = ∫ |u_s(x)|² ds / (π min(S, 1)²)    over |s| ≤ S = NA_illumination/NA_lens
//! ```
//!
//! A source point at the pupil's rim lights with ln² of its distance from it: radial nodes crowd there as a cube.
//! The pupil cuts f to a..b = ∓√(1 - s_y²) - s_x. The pole is taken out: where a < 0 < b,
//! `∫ g/f df = g(0) ln(b/|a|) + ∫ (g - g(0))/f df` is regular and Gauss-Legendre quadrature converges exponentially.

use std::f64::consts::{PI, TAU};

use super::esf::gauss_legendre;

/// Radial nodes a ring of the source, and nodes over half a turn of it.
const RADIAL: usize = 20;
const AROUND: usize = 40;

/// Edge image for coherence ratio `s` and defocus `zeta` at `2·count + 1` equal steps over ±reach (in λ/NA).
pub fn edge_image(s: f64, zeta: f64, reach: f64, count: usize) -> Vec<f64> {
    let mut image = vec![0.0; 2 * count + 1];
    let grid = Grid { reach, step: reach / count as f64, points: image.len() };
    let nodes = gauss_legendre(48 + (8.0 * reach) as usize);
    let full = PI * s.min(1.0).powi(2);
    for (sx, sy, weight) in source_points(s) {
        grid.add_source(&mut image, &nodes, [sx, sy], zeta, weight / full);
    }
    image
}

/// Points of the half disc s_y > 0 with weights that add up to the full disc's area; rings end at the pupil's rim.
fn source_points(s: f64) -> Vec<(f64, f64, f64)> {
    if s == 0.0 {
        // A single point; its weight cancels the norm in the limit.
        return vec![(0.0, 0.0, f64::NAN)];
    }
    // Rings as (the radius towards which nodes crowd, the other end).
    let rings = if s > 1.0 { vec![(1.0, 0.0), (1.0, s)] } else { vec![(s, 0.0)] };
    let radial = gauss_legendre(RADIAL);
    let mut points = Vec::new();
    for (crowded, other) in rings {
        for (x, w) in &radial {
            let u = 0.5 * (1.0 + x);
            let r = crowded + (other - crowded) * u.powi(3);
            let width = (other - crowded).abs() * 1.5 * u * u * w;
            for i in 0..AROUND {
                let (sin, cos) = (PI * (i as f64 + 0.5) / AROUND as f64).sin_cos();
                points.push((r * cos, r * sin, width * r * TAU / AROUND as f64));
            }
        }
    }
    points
}

struct Grid {
    reach: f64,
    step: f64,
    points: usize,
}

impl Grid {
    /// Adds |u_s|² of one source point.
    fn add_source(&self, image: &mut [f64], nodes: &[(f64, f64)], s: [f64; 2], zeta: f64, weight: f64) {
        let weight = if weight.is_nan() { 1.0 } else { weight };
        let cut = 1.0 - s[1] * s[1];
        if cut <= 0.0 {
            return;
        }
        let (a, b) = (-cut.sqrt() - s[0], cut.sqrt() - s[0]);
        let phase = |f: f64| PI * zeta * ((f + s[0]).powi(2) + s[1] * s[1]);
        let inside = a < 0.0 && b > 0.0;
        let centre = if inside { Complex::turn(phase(0.0)) } else { Complex::ZERO };
        let mut sum = vec![Complex::ZERO; self.points];
        for (x, w) in nodes {
            let f = a + (b - a) * 0.5 * (1.0 + x);
            let scale = 0.5 * (b - a) * w / f;
            let mut value = Complex::turn(phase(f) - TAU * f * self.reach);
            let turn = Complex::turn(TAU * f * self.step);
            for u in &mut sum {
                *u = u.plus(value.minus(centre).times_real(scale));
                value = value.times(turn);
            }
        }
        let log = if inside { (b / -a).ln() } else { 0.0 };
        for (out, u) in image.iter_mut().zip(sum) {
            // 1/(2πi)·(sum + centre·log) + centre/2
            let v = u.plus(centre.times_real(log)).times_real(1.0 / TAU);
            let amplitude = Complex { re: v.im + 0.5 * centre.re, im: -v.re + 0.5 * centre.im };
            *out += weight * (amplitude.re * amplitude.re + amplitude.im * amplitude.im);
        }
    }
}

#[derive(Clone, Copy)]
struct Complex {
    re: f64,
    im: f64,
}

impl Complex {
    const ZERO: Self = Self { re: 0.0, im: 0.0 };

    fn turn(angle: f64) -> Self {
        let (im, re) = angle.sin_cos();
        Self { re, im }
    }

    fn plus(self, o: Self) -> Self {
        Self { re: self.re + o.re, im: self.im + o.im }
    }

    fn minus(self, o: Self) -> Self {
        Self { re: self.re - o.re, im: self.im - o.im }
    }

    fn times(self, o: Self) -> Self {
        Self { re: self.re * o.re - self.im * o.im, im: self.re * o.im + self.im * o.re }
    }

    fn times_real(self, k: f64) -> Self {
        Self { re: self.re * k, im: self.im * k }
    }
}
