//! Penalised least squares of the sectors' radii.
//!
//! The smooth z of radii y with weights w has the least Σ w·(y − z)² + λ·Σ(Δ²z)²: (W + λ·DᵀD)·z =
//! W·y, five diagonals. Decomposed as L·D·Lᵀ, solved in 10 n operations, so that the penalty of
//! least cross-validation is found among all of them without a dense matrix.

use nalgebra::{DMatrix, DVector};

use super::limits::NoseLimits;

/// The matrix that smooths departures: that of the penalty of least generalised cross-validation,
/// times the share that leaves little to smoothing. `None` where a weight is not above 0.
pub(super) fn smoother(departures: &DVector<f64>, weights: &DVector<f64>) -> Option<DMatrix<f64>> {
    let limits = NoseLimits::get();
    let n = departures.len();
    let weights = weights / (weights.sum() / n as f64);
    let mut best: Option<(f64, f64)> = None;
    for power in 0..limits.penalties {
        let penalty = 0.01 * 4f64.powi(power as i32);
        let decomposed = Pentadiagonal::of(&weights, penalty)?;
        let residual = departures - decomposed.solved(departures.component_mul(&weights));
        let left = n as f64 - decomposed.inverse_diagonal().dot(&weights);
        let score = residual.component_mul(&residual).dot(&weights) / (left * left).max(1e-9);
        if best.is_none_or(|(least, _)| score < least) {
            best = Some((score, penalty));
        }
    }
    let decomposed = Pentadiagonal::of(&weights, best?.1 * limits.penalty_share)?;
    let column = |k: usize| {
        let mut unit = DVector::zeros(n);
        unit[k] = weights[k];
        decomposed.solved(unit)
    };
    Some(DMatrix::from_columns(&(0..n).map(column).collect::<Vec<_>>()))
}

/// W + λ·DᵀD as L·D·Lᵀ.
struct Pentadiagonal {
    /// D.
    diagonal: Vec<f64>,
    /// First and second diagonal of L below the main one, by row.
    below: Vec<[f64; 2]>,
}

impl Pentadiagonal {
    /// `None` of a matrix that is not positive definite.
    fn of(weights: &DVector<f64>, penalty: f64) -> Option<Self> {
        let n = weights.len();
        // rows of DᵀD: those of 1, −4, 6, −4, 1 but for the differences that the ends lack
        let second = |k: usize, i: usize| match k.abs_diff(i) {
            0 => -2.0,
            1 => 1.0,
            _ => 0.0,
        };
        let rough = |i: usize, j: usize| {
            let differences = j.max(1) - 1..=(i + 1).min(n.saturating_sub(2));
            differences.filter(|k| (1..n - 1).contains(k)).map(|k| second(k, i) * second(k, j)).sum::<f64>()
        };
        let (mut diagonal, mut below) = (vec![0.0; n], vec![[0.0; 2]; n]);
        for i in 0..n {
            let (mut first, mut far) = (0.0, 0.0);
            if i >= 2 {
                far = penalty * rough(i, i - 2) / diagonal[i - 2];
            }
            if i >= 1 {
                let by = if i >= 2 { far * below[i - 1][0] * diagonal[i - 2] } else { 0.0 };
                first = (penalty * rough(i, i - 1) - by) / diagonal[i - 1];
            }
            let mut own = weights[i] + penalty * rough(i, i);
            own -= if i >= 1 { first * first * diagonal[i - 1] } else { 0.0 };
            own -= if i >= 2 { far * far * diagonal[i - 2] } else { 0.0 };
            if !(own > 0.0) {
                return None;
            }
            (diagonal[i], below[i]) = (own, [first, far]);
        }
        Some(Self { diagonal, below })
    }

    /// The solution for a right side.
    fn solved(&self, mut x: DVector<f64>) -> DVector<f64> {
        let n = x.len();
        for i in 1..n {
            let [first, far] = self.below[i];
            x[i] -= first * x[i - 1] + if i >= 2 { far * x[i - 2] } else { 0.0 };
        }
        x.iter_mut().zip(&self.diagonal).for_each(|(x, d)| *x /= d);
        for i in (0..n).rev() {
            for (k, by) in [1, 2].into_iter().filter(|by| i + by < n).map(|by| (i + by, by - 1)) {
                x[i] -= self.below[k][by] * x[k];
            }
        }
        x
    }

    /// The diagonal of the inverse Z: by D⁻¹ + (1 − Lᵀ)·Z = Z the elements next to it follow from
    /// those below (K. Takahashi, J. Fagan, M.-S. Chin, Proc. 8th PICA Conf. (1973) 63).
    fn inverse_diagonal(&self) -> DVector<f64> {
        let n = self.diagonal.len();
        let below = |k: usize, by: usize| if k < n { self.below[k][by] } else { 0.0 };
        // Z of (i+1, i+1), (i+2, i+1), (i+2, i+2)
        let (mut next, mut between, mut far) = (0.0, 0.0, 0.0);
        let mut diagonal = DVector::zeros(n);
        for i in (0..n).rev() {
            let (a, b) = (below(i + 1, 0), below(i + 2, 1));
            let (beside, second) = (-a * next - b * between, -a * between - b * far);
            let own = self.diagonal[i].recip() - a * beside - b * second;
            diagonal[i] = own;
            (next, between, far) = (own, beside, next);
        }
        diagonal
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dense(weights: &DVector<f64>, penalty: f64) -> DMatrix<f64> {
        let n = weights.len();
        let mut differences = DMatrix::<f64>::zeros(n - 2, n);
        for k in 0..n - 2 {
            (differences[(k, k)], differences[(k, k + 1)], differences[(k, k + 2)]) = (1.0, -2.0, 1.0);
        }
        DMatrix::from_diagonal(weights) + differences.transpose() * &differences * penalty
    }

    #[test]
    fn five_diagonals_are_solved_and_inverted_as_the_dense_matrix() {
        for n in [8, 9, 31] {
            let weights = DVector::from_iterator(n, (0..n).map(|k| 0.5 + (k as f64 * 0.618).fract()));
            for penalty in [1e-4, 0.3, 1e5] {
                let inverse = dense(&weights, penalty).try_inverse().unwrap();
                let found = Pentadiagonal::of(&weights, penalty).unwrap();
                let right = DVector::from_iterator(n, (0..n).map(|k| (k as f64).sin()));
                let off = (found.solved(right.clone()) - &inverse * right).amax();
                assert!(off < 1e-9, "{n} {penalty}: {off}");
                let off = (found.inverse_diagonal() - inverse.diagonal()).amax();
                assert!(off < 1e-9, "{n} {penalty}: {off}");
            }
        }
        assert!(Pentadiagonal::of(&DVector::from_element(8, -1.0), 0.1).is_none());
    }

    #[test]
    fn a_smoother_keeps_lines_and_its_matrix_is_that_of_the_dense_equations() {
        let n = 40;
        let weights = DVector::from_iterator(n, (0..n).map(|k| 1.0 + (k as f64 * 0.38).fract()));
        let noisy = DVector::from_iterator(n, (0..n).map(|k| (k as f64 * 0.618).fract()));
        let hat = smoother(&noisy, &weights).unwrap();
        let line = DVector::from_iterator(n, (0..n).map(|k| 3.0 - 0.2 * k as f64));
        assert!((&hat * &line - &line).amax() < 1e-9);
        // W·H⁻¹ = W + λ·DᵀD: H is the smoother of one penalty
        let usual = &weights / (weights.sum() / n as f64);
        let by =
            |penalty: f64| dense(&usual, penalty).try_inverse().unwrap() * DMatrix::from_diagonal(&usual);
        let share = NoseLimits::get().penalty_share;
        let nearest = (0..NoseLimits::get().penalties)
            .map(|power| (by(share * 0.01 * 4f64.powi(power as i32)) - &hat).amax())
            .fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-9, "{nearest}");
    }
}
