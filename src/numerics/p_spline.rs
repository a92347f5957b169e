//! A penalised cubic spline over even knots, its smoothness by generalised cross-validation.
//!
//! Σ (y − B·c)² + λ·|D₂·c|² (Eilers and Marx 1996); λ minimises n·RSS/(n − tr H)² (Craven and Wahba
//! 1979), H the influence matrix. Where the samples have no noise λ falls to the least one tried
//! and the spline is that of least squares; where they are noise alone it is a straight line. The
//! effective number of parameters is tr H, the noise estimated as RSS/(n − tr H).

use nalgebra::{DMatrix, DVector};

/// Powers of ten of λ, in units of the mean weight of a coefficient: from none to a straight line.
const FROM: f64 = -8.0;
const TO: f64 = 8.0;
/// Steps between them: a quarter of a power moves the error by a hundredth.
const STEPS: usize = 64;

/// A penalised spline.
#[derive(Clone, Debug)]
pub(crate) struct PSpline {
    from: f64,
    to: f64,
    segments: usize,
    coefficients: DVector<f64>,
    /// Effective number of parameters, tr H.
    pub(crate) parameters: f64,
    /// Standard deviation of a sample about the spline.
    pub(crate) noise: f64,
}

impl PSpline {
    /// A spline through samples at places of a range; none where there are fewer samples than four,
    /// or places outside.
    pub(crate) fn fitted(x: &[f64], y: &[f64], [from, to]: [f64; 2], segments: usize) -> Option<Self> {
        let inside = x.iter().all(|x| (from..=to).contains(x));
        if x.len() < 4 || x.len() != y.len() || segments == 0 || !(to > from) || !inside {
            return None;
        }
        let count = segments + 3;
        let mut basis = DMatrix::zeros(x.len(), count);
        for (i, x) in x.iter().enumerate() {
            let (first, values) = cubic(*x, [from, to], segments);
            for (k, value) in values.into_iter().enumerate() {
                basis[(i, first + k)] = value;
            }
        }
        let normal = basis.tr_mul(&basis);
        let weight = normal.trace() / count as f64;
        let penalty = second_differences(count) * weight;
        let right = basis.tr_mul(&DVector::from_column_slice(y));
        let square: f64 = y.iter().map(|y| y * y).sum();
        let samples = Summed { normal, penalty, right, square, count: x.len() };
        let tried = (0..=STEPS)
            .filter_map(|k| samples.solved(10f64.powf(FROM + (TO - FROM) * k as f64 / STEPS as f64)));
        let best = tried.min_by(|a, b| a.score.total_cmp(&b.score))?;
        let free = (x.len() as f64 - best.parameters).max(f64::MIN_POSITIVE);
        let noise = (best.residual / free).sqrt();
        Some(Self { from, to, segments, coefficients: best.coefficients, parameters: best.parameters, noise })
    }

    /// The value at a place; none outside the range.
    pub(crate) fn value(&self, x: f64) -> Option<f64> {
        if !(self.from..=self.to).contains(&x) {
            return None;
        }
        let (first, values) = cubic(x, [self.from, self.to], self.segments);
        Some(values.iter().enumerate().map(|(k, v)| v * self.coefficients[first + k]).sum())
    }
}

/// Sums over the samples.
struct Summed {
    normal: DMatrix<f64>,
    penalty: DMatrix<f64>,
    right: DVector<f64>,
    square: f64,
    count: usize,
}

/// A spline by one λ.
struct Solved {
    coefficients: DVector<f64>,
    parameters: f64,
    residual: f64,
    score: f64,
}

impl Summed {
    fn solved(&self, smoothing: f64) -> Option<Solved> {
        let factor = (&self.normal + &self.penalty * smoothing).cholesky()?;
        let coefficients = factor.solve(&self.right);
        let parameters = factor.solve(&self.normal).trace();
        // |y − Bc|² = y² − 2·c·Bᵀy + c·BᵀB·c
        let fitted = coefficients.dot(&(&self.normal * &coefficients));
        let residual = (self.square - 2.0 * coefficients.dot(&self.right) + fitted).max(0.0);
        let free = self.count as f64 - parameters;
        let score = self.count as f64 * residual / (free * free);
        (free > 0.0).then_some(Solved { coefficients, parameters, residual, score })
    }
}

/// DᵀD of the second differences.
fn second_differences(count: usize) -> DMatrix<f64> {
    let mut sum = DMatrix::zeros(count, count);
    for k in 0..count - 2 {
        for (i, a) in [(k, 1.0), (k + 1, -2.0), (k + 2, 1.0)] {
            for (j, b) in [(k, 1.0), (k + 1, -2.0), (k + 2, 1.0)] {
                sum[(i, j)] += a * b;
            }
        }
    }
    sum
}

/// The first of four cubic B-splines at a place, and their values.
fn cubic(x: f64, [from, to]: [f64; 2], segments: usize) -> (usize, [f64; 4]) {
    let place = ((x - from) / (to - from) * segments as f64).clamp(0.0, segments as f64);
    let first = (place as usize).min(segments - 1);
    let t = place - first as f64;
    let (s, t2, t3) = (1.0 - t, t * t, t * t * t);
    let values = [
        s * s * s / 6.0,
        (3.0 * t3 - 6.0 * t2 + 4.0) / 6.0,
        (-3.0 * t3 + 3.0 * t2 + 3.0 * t + 1.0) / 6.0,
        t3 / 6.0,
    ];
    (first, values)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places() -> Vec<f64> {
        (0..51).map(|k| 2.0 * f64::from(k)).collect()
    }

    #[test]
    fn without_noise_a_cubic_returns_and_beyond_the_range_is_none() {
        let cubic = |x: f64| 1.0 - 0.02 * x + 3e-4 * x * x - 2e-6 * x * x * x;
        let x = places();
        let y: Vec<f64> = x.iter().map(|x| cubic(*x)).collect();
        let spline = PSpline::fitted(&x, &y, [0.0, 100.0], 25).unwrap();
        for x in [0.0, 1.0, 33.3, 77.7, 100.0] {
            assert!((spline.value(x).unwrap() - cubic(x)).abs() < 1e-5, "{x}");
        }
        assert_eq!((spline.value(-0.1), spline.value(100.1)), (None, None));
    }

    #[test]
    fn alternating_samples_about_a_line_give_nearly_the_line() {
        let x = places();
        let y: Vec<f64> =
            x.iter().enumerate().map(|(k, x)| 0.5 + 0.01 * x + 0.1 * (-1f64).powi(k as i32)).collect();
        let spline = PSpline::fitted(&x, &y, [0.0, 100.0], 25).unwrap();
        assert!(spline.parameters < 4.0, "{}", spline.parameters);
        assert!((spline.value(51.0).unwrap() - 1.01).abs() < 0.01);
        assert!((spline.noise - 0.1).abs() < 0.01, "{}", spline.noise);
    }

    #[test]
    fn samples_that_do_not_fit_give_none() {
        assert!(PSpline::fitted(&[0.0, 1.0, 2.0], &[0.0; 3], [0.0, 2.0], 2).is_none());
        assert!(PSpline::fitted(&[0.0, 1.0, 2.0, 9.0], &[0.0; 4], [0.0, 2.0], 2).is_none());
    }
}
