//! Normal equations of a small linear least-squares problem, summed point by point.

use nalgebra::{SMatrix, SVector};

/// Σ w·φφᵀ and Σ w·y·φ.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NormalEquations<const N: usize> {
    /// Σ w·φφᵀ.
    pub(crate) normal: SMatrix<f64, N, N>,
    /// Σ w·y·φ.
    pub(crate) right: SVector<f64, N>,
}

impl<const N: usize> NormalEquations<N> {
    /// Without any point.
    pub(crate) fn new() -> Self {
        Self { normal: SMatrix::zeros(), right: SVector::zeros() }
    }

    /// Adds a point by its terms φ, its value y and its weight w.
    pub(crate) fn add(&mut self, terms: SVector<f64, N>, value: f64, weight: f64) {
        self.normal += terms * terms.transpose() * weight;
        self.right += terms * (weight * value);
    }

    /// Coefficients by the inverse, for callers that also need the inverse or whose matrix may not
    /// be definite.
    pub(crate) fn by_inverse(&self) -> Option<SVector<f64, N>> {
        Some(self.normal.try_inverse()? * self.right)
    }

    /// Coefficients by Cholesky's decomposition; `None` where the points do not determine them.
    pub(crate) fn by_cholesky(&self) -> Option<SVector<f64, N>> {
        Some(self.normal.cholesky()?.solve(&self.right))
    }
}
