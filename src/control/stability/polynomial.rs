//! Real polynomials in the forward shift: roots, Jury's test, transient growth of the companion
//! matrix.

use nalgebra::DMatrix;

/// Growth beyond this is not followed further.
pub(super) const UNBOUNDED: f64 = 1e12;

/// Σ c_i q^i, coefficients in ascending order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Polynomial {
    coefficients: Vec<f64>,
}

impl Polynomial {
    /// From coefficients in ascending order; leading zeros are dropped.
    pub(crate) fn new(coefficients: impl Into<Vec<f64>>) -> Self {
        let mut coefficients = coefficients.into();
        while coefficients.len() > 1 && coefficients.last() == Some(&0.0) {
            coefficients.pop();
        }
        Self { coefficients }
    }

    /// Coefficients in ascending order.
    pub(crate) fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// Highest power.
    pub(crate) fn degree(&self) -> usize {
        self.coefficients.len().saturating_sub(1)
    }

    /// Product.
    pub(crate) fn times(&self, other: &Self) -> Self {
        let mut product = vec![0.0; self.degree() + other.degree() + 1];
        for (i, a) in self.coefficients.iter().enumerate() {
            for (j, b) in other.coefficients.iter().enumerate() {
                product[i + j] += a * b;
            }
        }
        Self::new(product)
    }

    /// Sum.
    pub(crate) fn plus(&self, other: &Self) -> Self {
        let at = |p: &Self, i: usize| p.coefficients.get(i).copied().unwrap_or(0.0);
        let length = self.coefficients.len().max(other.coefficients.len());
        Self::new((0..length).map(|i| at(self, i) + at(other, i)).collect::<Vec<_>>())
    }

    /// Multiplied by a number.
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        Self::new(self.coefficients.iter().map(|c| c * factor).collect::<Vec<_>>())
    }

    /// Roots (real, imaginary), largest modulus first: eigenvalues of the companion matrix.
    pub(crate) fn roots(&self) -> Vec<(f64, f64)> {
        if self.degree() == 0 {
            return Vec::new();
        }
        let mut roots: Vec<(f64, f64)> =
            self.companion().complex_eigenvalues().iter().map(|c| (c.re, c.im)).collect();
        roots.sort_by(|a, b| b.0.hypot(b.1).total_cmp(&a.0.hypot(a.1)).then(b.1.total_cmp(&a.1)));
        roots
    }

    /// Companion matrix of the monic polynomial: ones above the diagonal, −c_i/c_n in the last row.
    pub(crate) fn companion(&self) -> DMatrix<f64> {
        let n = self.degree();
        let lead = self.coefficients.last().copied().unwrap_or(1.0);
        DMatrix::from_fn(n, n, |row, column| match (row + 1 == n, column == row + 1) {
            (true, _) => -self.coefficients[column] / lead,
            (false, true) => 1.0,
            (false, false) => 0.0,
        })
    }

    /// Whether all roots lie inside the unit circle: Jury's table in the form of Schur and Cohn,
    /// which lowers the degree by one per step: a stable p has |p(0)| < |leading coefficient|, and
    /// so has every reduced polynomial. (E. I. Jury, Theory and Application of the z-Transform
    /// Method, 1964, ch. 3.)
    pub(crate) fn jury_stable(&self) -> bool {
        let mut c = self.coefficients.clone();
        while c.len() > 1 {
            let (first, last) = (c[0], c[c.len() - 1]);
            let reflection = first / last;
            if reflection.abs() >= 1.0 || reflection.is_nan() {
                return false;
            }
            let reversed: Vec<f64> = c.iter().rev().copied().collect();
            c = c.iter().zip(&reversed).skip(1).map(|(a, b)| a - reflection * b).collect();
        }
        true
    }

    /// Largest spectral norm of the powers 1..=`passes` of the companion matrix.
    pub(crate) fn transient_growth(&self, passes: usize) -> f64 {
        let a = self.companion();
        let mut power = a.clone();
        let mut largest = 0.0_f64;
        for _ in 0..passes {
            largest = largest.max(power.clone().svd(false, false).singular_values.max());
            power = &power * &a;
            if largest > UNBOUNDED {
                break;
            }
        }
        largest
    }
}
