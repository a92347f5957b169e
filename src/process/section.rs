//! Stiffness of a solid circular cross-section.

use super::material::Material;

/// Bending and shear stiffness of a cross-section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Section {
    /// E·I, N·mm².
    pub bending_n_mm2: f64,
    /// κ·G·A, N; infinite for an Euler-Bernoulli beam.
    pub shear_n: f64,
}

impl Section {
    /// Solid circle of `diameter_mm`: I = πd⁴/64, A = πd²/4, G = E/2(1+ν) and Cowper's
    /// κ = 6(1+ν)/(7+6ν) (G. R. Cowper, J. Appl. Mech. 33, 1966).
    pub(crate) fn circular(diameter_mm: f64, material: &Material) -> Self {
        let poisson = material.poisson_ratio;
        let area = std::f64::consts::FRAC_PI_4 * diameter_mm * diameter_mm;
        let shear_modulus = material.youngs_modulus_n_per_mm2 / (2.0 * (1.0 + poisson));
        let kappa = 6.0 * (1.0 + poisson) / (7.0 + 6.0 * poisson);
        Self {
            bending_n_mm2: material.youngs_modulus_n_per_mm2 * area * diameter_mm * diameter_mm / 16.0,
            shear_n: kappa * shear_modulus * area,
        }
    }

    /// The same section without shear deformation.
    #[must_use]
    #[cfg(test)]
    pub(crate) fn without_shear(self) -> Self {
        Self { shear_n: f64::INFINITY, ..self }
    }
}
