//! Spectrum of a partially coherent edge from Hopkins' transmission cross-coefficient.
//!
//! Frequencies in NA/λ, distances in λ/NA, defocus z in λ/NA². With the edge's spectrum T(f) =
//! δ(f)/2 + 1/(2πif) and the cross-coefficient C(f1, f2) of a circular pupil and a circular source
//! of relative radius S,
//!
//! ```text
//! I(x) = ∬ T(f1) T*(f2) C(f1,f2) e^{2πi(f1-f2)x} df1 df2
//!      = 1/2 + 1/π ∫₀² [Gr(ν) sin 2πνx + Gi(ν) cos 2πνx] dν/ν
//! Gr(ν) = Re C(ν,0),   Gi(ν) = 1/π PV∫ Re C(f+ν,f) df/f
//! ```
//!
//! By partial fractions the two poles 1/f1f2 at f1 - f2 = ν become (1/f2 - 1/f1)/ν, and because of
//! C(-f1,-f2) = C(f1,f2) = C*(f2,f1) only the real part remains. C is the integral over source
//! points (ξ,η) that pass both shifted pupils; with the pupils' midpoint p = f + ν/2 + ξ its phase
//! 2πzνp does not depend on f, so the principal value over f has the closed form
//!
//! ```text
//! Gi(ν) = 1/(π² S₁²) ∬ cos(2πzνp) ln|(q+s)/(q-s)| dp dη,   q = p - ν/2,   |p| ≤ a - ν/2
//! s = √(S²-η²),   a = √(1-η²),   S₁ = min(S,1)
//! ```
//!
//! It has one dimension more than in focus, where the integral over p has a primitive. The image is
//! normalised to I(∞) = 1, that is to the source points that pass the pupil. Hopkins, Proc. R. Soc.
//! A 217 (1953) 408; Born & Wolf, Principles of Optics, 10.6.4 (the cross-coefficient).

use std::f64::consts::{FRAC_PI_2, PI};

use super::quadrature::{gauss_legendre, panels};

/// Nodes across the pupil (η) on each side of the break: the spectrum is accurate to 1e-7.
const ACROSS: usize = 32;

/// Nodes along the pupil (p) between two singular points, with ends smoothed to t³.
const ALONG: usize = 32;

/// Phase 2πzν per half pupil up to which [`ALONG`] nodes suffice; their number increases in
/// proportion beyond.
const PHASE: f64 = 20.0;

/// Quadrature rules common to all frequencies.
pub(super) struct Spectrum {
    /// Relative source radius, above 0.
    s: f64,
    /// Defocus, λ/NA².
    z: f64,
    across: Vec<(f64, f64)>,
    /// Nodes t in 0..1 and weights after the smoothing t³(10 - 15t + 6t²).
    along: Vec<(f64, f64)>,
}

impl Spectrum {
    pub(super) fn new(s: f64, z: f64) -> Self {
        let count = (ALONG as f64 * (4.0 * PI * z.abs() / PHASE).max(1.0)).ceil() as usize;
        let along = gauss_legendre(count)
            .into_iter()
            .map(|(x, w)| {
                let t = 0.5 * (x + 1.0);
                (t * t * t * (10.0 - 15.0 * t + 6.0 * t * t), 0.5 * w * 30.0 * (t * (1.0 - t)).powi(2))
            })
            .collect();
        Self { s, z, across: gauss_legendre(ACROSS), along }
    }

    /// Frequencies at which the overlap of pupils and source changes its shape.
    pub(super) fn breaks(&self) -> Vec<f64> {
        let s = self.s;
        vec![(1.0 - s).abs(), 1.0, 1.0 + s, 2.0 * s, 2.0 * (1.0 - s * s).abs().sqrt(), 1e-4, 1e-3, 1e-2, 0.05]
    }

    /// Gr and Gi at ν in 0..2.
    pub(super) fn at(&self, nu: f64) -> (f64, f64) {
        let passed = self.s.min(1.0).powi(2);
        let real = self.over_pupil(nu, self.s.min(1.0), |a, s| self.overlap(nu, a, s));
        let half_chord = self.s.min((1.0 - 0.25 * nu * nu).max(0.0).sqrt());
        let imaginary = self.over_pupil(nu, half_chord, |a, s| self.principal_value(nu, a, s));
        (real / (PI * passed), imaginary / (PI * PI * passed))
    }

    /// ∫ f(a(η), s(η)) dη over |η| ≤ m, with η = m sin t against the roots at the ends, divided
    /// where |s ± ν| = a.
    fn over_pupil(&self, nu: f64, m: f64, f: impl Fn(f64, f64) -> f64) -> f64 {
        let meet = 0.5 * (nu + (1.0 - self.s * self.s) / nu);
        let eta = (1.0 - meet * meet).max(0.0).sqrt();
        let divide = if eta < m { (eta / m).asin() } else { 0.0 };
        let nodes = panels(0.0, FRAC_PI_2, &[divide], FRAC_PI_2, &self.across);
        let term = |(t, w): &(f64, f64)| {
            let (sin, cos) = t.sin_cos();
            let square = (m * sin).powi(2);
            w * m * cos * f((1.0 - square).max(0.0).sqrt(), (self.s * self.s - square).max(0.0).sqrt())
        };
        2.0 * nodes.iter().map(term).sum::<f64>()
    }

    /// ∫ cos(πzν(2ξ+ν)) dξ over the source's chord that passes both pupils.
    fn overlap(&self, nu: f64, a: f64, s: f64) -> f64 {
        let (low, high) = (-s.min(a), s.min(a - nu));
        let length = high - low;
        if length <= 0.0 {
            return 0.0;
        }
        let phase = PI * self.z * nu;
        let half = phase * length;
        let sinc = if half.abs() < 1e-8 { 1.0 } else { half.sin() / half };
        length * (phase * (high + low + nu)).cos() * sinc
    }

    /// ∫ cos(2πzνp) ln|(q+s)/(q-s)| dp over |p| ≤ a - ν/2.
    fn principal_value(&self, nu: f64, a: f64, s: f64) -> f64 {
        if self.z == 0.0 {
            return primitive(a - nu, s) - primitive(a, s);
        }
        let half = a - 0.5 * nu;
        let inside = |p: f64| p.clamp(-half, half);
        let ends = [-half, inside(0.5 * nu - s), inside(0.5 * nu + s), half];
        let k = 2.0 * PI * self.z * nu;
        let ln = |t: f64| t.abs().max(f64::MIN_POSITIVE).ln();
        let piece = |from: f64, to: f64| {
            let term = |(t, w): &(f64, f64)| {
                let p = from + (to - from) * t;
                let q = p - 0.5 * nu;
                w * (k * p).cos() * (ln(q + s) - ln(q - s))
            };
            (to - from) * self.along.iter().map(term).sum::<f64>()
        };
        ends.windows(2).filter(|e| e[1] > e[0]).map(|e| piece(e[0], e[1])).sum()
    }
}

/// Primitive of ln|(q+s)/(q-s)|.
fn primitive(q: f64, s: f64) -> f64 {
    let x_ln_x = |t: f64| if t == 0.0 { 0.0 } else { t * t.abs().ln() };
    x_ln_x(q + s) - x_ln_x(q - s)
}

/// OTF of an incoherently lit circular pupil with defocus: Gr for S → ∞, where Gi vanishes.
pub(super) fn incoherent(nu: f64, z: f64) -> f64 {
    let half = 0.5 * nu;
    if half >= 1.0 {
        return 0.0;
    }
    let in_focus = 2.0 / PI * (half.acos() - half * (1.0 - half * half).sqrt());
    if z == 0.0 {
        return in_focus;
    }
    // ∫∫ cos(2πzνp) dp dη over |p| ≤ a(η) - ν/2, divided by the pupil's area.
    let k = 2.0 * PI * z * nu;
    let m = (1.0 - half * half).sqrt();
    let rule = gauss_legendre(24);
    let nodes = panels(0.0, FRAC_PI_2, &[], FRAC_PI_2 / (1.0 + (k / PHASE).abs()).ceil(), &rule);
    let term = |(t, w): &(f64, f64)| {
        let (sin, cos) = t.sin_cos();
        let b = (1.0 - (m * sin).powi(2)).sqrt() - half;
        let sinc = if (k * b).abs() < 1e-8 { b } else { (k * b).sin() / k };
        w * m * cos * sinc
    };
    4.0 / PI * nodes.iter().map(term).sum::<f64>()
}
