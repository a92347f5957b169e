//! Iterative learning along the whole shaft at once: o(k+1) = Q (I − L G) o(k) + …, G the plant
//! from offsets to errors.
//!
//! Converges where the spectral radius is below 1; the error decreases monotonically where the norm
//! is below 1 (Bristow, Tharayil, Alleyne 2006, theorems 1 and 2).

use nalgebra::DMatrix;

/// Convergence of an iteration matrix.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub(crate) struct IterationReport {
    /// Largest modulus of an eigenvalue of Q (I − L G).
    pub spectral_radius: f64,
    /// Largest singular value of Q (I − L G).
    pub norm: f64,
    /// Largest share of a constant disturbance that remains in the limit: norm of I − G [I − Q (I −
    /// L G)]⁻¹ Q L, infinite where the iteration does not converge.
    pub left_over: f64,
}

/// Assesses a filter Q, a learning gain L and a plant G (errors −G o), over all stations.
pub(crate) fn iteration(q: &DMatrix<f64>, learning_gain: f64, plant: &DMatrix<f64>) -> IterationReport {
    let identity = DMatrix::identity(q.nrows(), q.ncols());
    let step = q * (&identity - plant * learning_gain);
    let spectral_radius = step.complex_eigenvalues().iter().map(|c| c.norm()).fold(0.0, f64::max);
    let norm = step.clone().svd(false, false).singular_values.max();
    // at rest o = Q [o + L (d − G o)], so e = d − G o with o = (I − step)⁻¹ Q L d
    let settled = (&identity - &step).try_inverse().map(|inverse| {
        let left = &identity - plant * (inverse * q * learning_gain);
        left.svd(false, false).singular_values.max()
    });
    let left_over = settled.filter(|_| spectral_radius < 1.0).unwrap_or(f64::INFINITY);
    IterationReport { spectral_radius, norm, left_over }
}

/// The Q filter of `[control.ilc]` for stations of even pitch; identity where nothing is filtered.
pub(crate) fn whittaker(cutoff_mm: f64, station_z_mm: &[f64]) -> DMatrix<f64> {
    let n = station_z_mm.len();
    crate::control::law::q_filter(cutoff_mm, station_z_mm).unwrap_or_else(|| DMatrix::identity(n, n))
}
