//! The surface of a cylinder to grazing light: its impedance, for both polarisations.
//!
//! At grazing incidence the field on a surface obeys ∂u/∂n = k g u, and its reciprocal 1/g is what
//! enters: the surface seems displaced outwards by -(λ/2π) Re(1/g). With the refractive index m = n
//! + iκ, time as e^(-iωt) and b = √(m_f² - 1) of a film of thickness t,
//!
//! ```text
//! E along the axis (TM)   g = -i √(m² - 1)        p = 1
//! H along the axis (TE)   g = -i √(m² - 1)/m²     p = 1/m_f²
//! film                    g' = p (G cos β - b sin β)/(cos β + (G/b) sin β),   G = g/p, β = b k t
//! roughness               1/g' = 1/g - k c,   c = .489 Rq² √(2k/L)(1 - i)
//! ```
//!
//! c is ∬W √(K² + 2kK_y) d²K over the spectrum W of heights about the mean line (first order in
//! W; Rice, Commun. Pure Appl. Math. 4 (1951) 351), for the correlation e^(-(y/L)²) along the light
//! with L long against the wavelength; the root is -i√|·| where its radicand is negative.

use rustfft::num_complex::Complex;

use super::airy::C;

/// Factor of a rough surface, e^(-(y/L)²) along the light: Γ(3/4)/√(2π).
const ROUGH: f64 = 0.488_872_4;

/// ∂u/∂n = k g u as the pair (a, b) of a ∂u/∂n = k b u: (0, 1) soft (E along the axis of an ideal
/// conductor), (1, 0) hard (H along it).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Boundary {
    pub(crate) slope: C,
    pub(crate) value: C,
}

impl Boundary {
    /// u = 0 on the surface.
    #[cfg(test)]
    pub(crate) fn soft() -> Self {
        Self { slope: Complex::new(0.0, 0.0), value: Complex::new(1.0, 0.0) }
    }

    /// ∂u/∂n = 0 on the surface.
    #[cfg(test)]
    pub(crate) fn hard() -> Self {
        Self { slope: Complex::new(1.0, 0.0), value: Complex::new(0.0, 0.0) }
    }

    /// The pair (a, b).
    #[cfg(test)]
    pub(crate) fn pair(self) -> [C; 2] {
        [self.slope, self.value]
    }

    /// The boundary in the limb's own lengths, where ∂u/∂ν = M g u.
    pub(crate) fn scaled(self, m: f64) -> Self {
        Self { slope: self.slope, value: self.value * m }
    }
}

/// What the light meets: a body, a film and a texture on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Surface {
    /// Refractive index n + iκ of the body.
    pub index: C,
    /// Thickness of a transparent film on it, µm; 0 for none.
    pub film_um: f64,
    /// The film's refractive index.
    pub film_index: f64,
    /// Rq of the roughness along the light, about the mean line, µm.
    pub roughness_um: f64,
    /// Its correlation length L, µm.
    pub correlation_um: f64,
}

impl Surface {
    /// The boundary at the wavenumber k (1/µm): E along the axis, or H along the axis.
    pub(crate) fn boundary(&self, k: f64, electric_along_axis: bool) -> Boundary {
        let square = self.index * self.index;
        let body = -C::i() * (square - 1.0).sqrt();
        let body = if electric_along_axis { body } else { body / square };
        let filmed = self.under_film(body, k, electric_along_axis);
        let rough = ROUGH * self.roughness_um.powi(2) * (2.0 * k / self.correlation_um).sqrt();
        let reciprocal = filmed.inv() - Complex::new(rough, -rough) * k;
        Boundary { slope: reciprocal, value: Complex::new(1.0, 0.0) }
    }

    fn under_film(&self, body: C, k: f64, electric_along_axis: bool) -> C {
        if self.film_um == 0.0 {
            return body;
        }
        let square = self.film_index * self.film_index;
        let p = if electric_along_axis { 1.0 } else { 1.0 / square };
        let b = (square - 1.0).sqrt();
        let (sin, cos) = (b * k * self.film_um).sin_cos();
        let g = body / p;
        (g * cos - b * sin) * p / (g * (sin / b) + cos)
    }
}
