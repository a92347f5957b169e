//! A cubic smoothing spline by regularised least squares over equidistant knots.

use nalgebra::{DMatrix, DVector};

/// The cubic B-spline's four values at the fraction `t` of a segment.
fn basis(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    let (t2, t3) = (t * t, t * t * t);
    [
        s * s * s / 6.0,
        (3.0 * t3 - 6.0 * t2 + 4.0) / 6.0,
        (-3.0 * t3 + 3.0 * t2 + 3.0 * t + 1.0) / 6.0,
        t3 / 6.0,
    ]
}

/// Derivatives of [`basis`] by t.
fn basis_slope(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [-0.5 * s * s, 1.5 * t * t - 2.0 * t, -1.5 * t * t + t + 0.5, 0.5 * t * t]
}

/// A cubic spline over `from..from + segments·step` by regularised least squares.
pub(crate) struct Spline {
    from: f64,
    pub(crate) step: f64,
    pub(crate) coefficients: DVector<f64>,
}

/// Normal equations of a spline.
#[derive(Debug)]
pub(crate) struct SplineFit {
    from: f64,
    step: f64,
    normal: DMatrix<f64>,
    right: DVector<f64>,
    /// Observations in every segment.
    pub(crate) counts: Vec<u32>,
}

impl SplineFit {
    pub(crate) fn new(from: f64, to: f64, segments: usize) -> Self {
        Self {
            from,
            step: (to - from) / segments as f64,
            normal: DMatrix::zeros(segments + 3, segments + 3),
            right: DVector::zeros(segments + 3),
            counts: vec![0; segments],
        }
    }

    pub(crate) fn add(&mut self, at: f64, value: f64) {
        let place = (at - self.from) / self.step;
        if !(place >= 0.0 && place <= self.counts.len() as f64) {
            return;
        }
        let k = (place as usize).min(self.counts.len() - 1);
        let b = basis(place - k as f64);
        self.counts[k] += 1;
        for i in 0..4 {
            self.right[k + i] += b[i] * value;
            for j in 0..4 {
                self.normal[(k + i, k + j)] += b[i] * b[j];
            }
        }
    }

    /// Solves with this weight of the squared second differences, in units of a knot's mean weight;
    /// with `clamped` ends, value and slope are zero at the ends.
    pub(crate) fn solve(mut self, smoothing: f64, clamped: bool) -> Option<Spline> {
        let n = self.right.len();
        let weight = self.normal.trace() / n as f64;
        for k in 1..n - 1 {
            for (i, a) in [(k - 1, 1.0), (k, -2.0), (k + 1, 1.0)] {
                for (j, b) in [(k - 1, 1.0), (k, -2.0), (k + 1, 1.0)] {
                    self.normal[(i, j)] += smoothing * weight * a * b;
                }
            }
        }
        if clamped {
            for k in [0, 1, 2, n - 3, n - 2, n - 1] {
                self.normal[(k, k)] += 1e6 * weight;
            }
        }
        let coefficients = self.normal.cholesky()?.solve(&self.right);
        Some(Spline { from: self.from, step: self.step, coefficients })
    }
}

impl Spline {
    /// Value and derivative; zero outside.
    pub(crate) fn at(&self, at: f64) -> (f64, f64) {
        let segments = self.coefficients.len() - 3;
        let place = (at - self.from) / self.step;
        if !(place >= 0.0 && place <= segments as f64) {
            return (0.0, 0.0);
        }
        let k = (place as usize).min(segments - 1);
        let (b, d) = (basis(place - k as f64), basis_slope(place - k as f64));
        let c = |i: usize| self.coefficients[k + i];
        let value = (0..4).map(|i| b[i] * c(i)).sum();
        (value, (0..4).map(|i| d[i] * c(i)).sum::<f64>() / self.step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spline_follows_a_cubic_and_its_slope() {
        let cubic = |x: f64| 0.3 - 0.2 * x + 0.05 * x * x - 0.01 * x * x * x;
        let mut fit = SplineFit::new(-2.0, 3.0, 9);
        for k in 0..400 {
            let x = -2.0 + 5.0 * f64::from(k) / 399.0;
            fit.add(x, cubic(x));
        }
        let spline = fit.solve(1e-5, false).unwrap();
        for x in [-1.9, -0.3, 0.0, 1.234, 2.9] {
            let (value, slope) = spline.at(x);
            assert!((value - cubic(x)).abs() < 2e-4, "{value} {}", cubic(x));
            assert!((slope - (-0.2 + 0.1 * x - 0.03 * x * x)).abs() < 3e-3, "{slope}");
        }
        assert_eq!(spline.at(3.1), (0.0, 0.0));
    }
}
