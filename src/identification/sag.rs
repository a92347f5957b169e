//! What stands still of a part's axis: its sag and what a tailstock across the axis does.
//!
//! A bar of uniform section from z = 0 to L under its own weight, q/EI = 16ρg/(E·d²) (Euler and
//! Bernoulli):
//!
//! ```text
//! overhung            q·z²(6L² − 4Lz + z²)/24EI
//! chuck and tailstock q·z²(3L² − 5Lz + 2z²)/48EI
//! centres             q·z(L³ − 2Lz² + z³)/24EI
//! ```
//!
//! A tailstock displaced by δ bends a chucked bar by δ·z²(3L − z)/2L³ and turns one between centres
//! by δ·z/L.

use super::reading_set::{Held, MidlinePart};

/// Standard acceleration of gravity, m/s².
const GRAVITY: f64 = 9.806_65;

impl MidlinePart {
    /// Sag in the direction of gravity at z, mm.
    pub(crate) fn sag_mm(&self, z_mm: f64) -> f64 {
        // kg/m³ · m/s² = 1e-9 N/mm³
        let load = 1e-9 * self.density_kg_per_m3 * GRAVITY;
        let q = 16.0 * load / (self.youngs_modulus_n_per_mm2 * self.diameter_mm * self.diameter_mm);
        let (l, z) = (self.length_mm, z_mm);
        match self.held {
            Held::Overhung => q * z * z * (6.0 * l * l - 4.0 * l * z + z * z) / 24.0,
            Held::ChuckAndTailstock => q * z * z * (3.0 * l * l - 5.0 * l * z + 2.0 * z * z) / 48.0,
            Held::Centres => q * z * (l * l * l - 2.0 * l * z * z + z * z * z) / 24.0,
        }
    }

    /// Displacement of the axis at z for a tailstock displaced by 1; none without a tailstock.
    pub(crate) fn tailstock(&self, z_mm: f64) -> Option<f64> {
        let s = z_mm / self.length_mm;
        match self.held {
            Held::Overhung => None,
            Held::ChuckAndTailstock => Some(0.5 * s * s * (3.0 - s)),
            Held::Centres => Some(s),
        }
    }
}
