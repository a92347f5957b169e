//! JᵀJ and Jᵀy of weighted equations in scaled unknowns, and their solution with a penalty.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::equations::{Equation, scaled};
use super::unknowns::Unknowns;

/// JᵀJ and Jᵀy.
#[derive(Clone, Debug)]
pub(super) struct Normal {
    /// JᵀJ.
    pub square: DMatrix<f64>,
    /// Jᵀy.
    pub right: DVector<f64>,
}

impl Normal {
    /// Of some equations.
    pub(super) fn of<'a>(equations: impl Iterator<Item = &'a Equation>, unknowns: &Unknowns) -> Self {
        let count = unknowns.all.len();
        let mut normal = Self { square: DMatrix::zeros(count, count), right: DVector::zeros(count) };
        for equation in equations {
            let row = scaled(equation, unknowns);
            let y = equation.value / equation.u;
            for (i, a) in &row {
                normal.right[*i] += a * y;
                for (j, b) in &row {
                    normal.square[(*i, *j)] += a * b;
                }
            }
        }
        normal
    }

    /// z = (JᵀJ + P)⁻¹Jᵀy with the factors of the matrix; none where it is not positive definite.
    pub(super) fn solve(&self, penalty: &DVector<f64>) -> Option<(DVector<f64>, Cholesky<f64, Dyn>)> {
        let mut square = self.square.clone();
        for (k, p) in penalty.iter().enumerate() {
            square[(k, k)] += p;
        }
        let cholesky = square.cholesky()?;
        Some((cholesky.solve(&self.right), cholesky))
    }
}
