//! The cubic spline through all samples, without curvature at its ends (de Boor 1978, IV).
//!
//! The second derivatives m at the samples solve h₀·m₀ + 2(h₀ + h₁)·m₁ + h₁·m₂ = 6(d₁ − d₀) with h
//! the steps and d the slopes of the chords. It follows every sample, noise and all.

/// A cubic spline through samples.
#[derive(Clone, Debug)]
pub(crate) struct CubicSpline {
    x: Vec<f64>,
    y: Vec<f64>,
    /// Second derivatives at the samples.
    second: Vec<f64>,
}

impl CubicSpline {
    /// The natural spline: without curvature at its ends. None for fewer than three samples, or
    /// places that do not ascend.
    pub(crate) fn natural(x: &[f64], y: &[f64]) -> Option<Self> {
        let n = x.len();
        if n < 3 || n != y.len() || x.windows(2).any(|pair| !(pair[1] > pair[0])) {
            return None;
        }
        let step = |k: usize| x[k + 1] - x[k];
        let chord = |k: usize| (y[k + 1] - y[k]) / step(k);
        // Thomas' algorithm; the matrix dominates by its diagonal
        let (mut upper, mut right) = (vec![0.0; n], vec![0.0; n]);
        for k in 1..n - 1 {
            let pivot = 2.0 * (step(k - 1) + step(k)) - step(k - 1) * upper[k - 1];
            upper[k] = step(k) / pivot;
            right[k] = (6.0 * (chord(k) - chord(k - 1)) - step(k - 1) * right[k - 1]) / pivot;
        }
        let mut second = vec![0.0; n];
        for k in (1..n - 1).rev() {
            second[k] = right[k] - upper[k] * second[k + 1];
        }
        Some(Self { x: x.to_vec(), y: y.to_vec(), second })
    }

    /// The value at a place; none outside the samples.
    pub(crate) fn value(&self, x: f64) -> Option<f64> {
        let last = self.x.len() - 1;
        if !(self.x[0]..=self.x[last]).contains(&x) {
            return None;
        }
        let k = self.x.partition_point(|p| *p <= x).clamp(1, last) - 1;
        let h = self.x[k + 1] - self.x[k];
        let (b, a) = ((x - self.x[k]) / h, (self.x[k + 1] - x) / h);
        let bend = (a * a * a - a) * self.second[k] + (b * b * b - b) * self.second[k + 1];
        Some(a * self.y[k] + b * self.y[k + 1] + bend * h * h / 6.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_goes_through_the_samples_and_between_them_by_the_fourth_derivative() {
        let x: Vec<f64> = (0..41).map(|k| f64::from(k) * std::f64::consts::PI / 20.0).collect();
        let y: Vec<f64> = x.iter().map(|x| x.sin()).collect();
        let spline = CubicSpline::natural(&x, &y).unwrap();
        for (x, y) in x.iter().zip(&y) {
            assert!((spline.value(*x).unwrap() - y).abs() < 1e-14);
        }
        // 5/384·h⁴ of a sine whose curvature is 0 at the ends, as the spline's
        let limit = 5.0 / 384.0 * (std::f64::consts::PI / 20.0).powi(4) * 1.05;
        let worst = (0..400).map(|k| f64::from(k) * std::f64::consts::PI / 200.0);
        let worst = worst.map(|x| (spline.value(x).unwrap() - x.sin()).abs()).fold(0.0, f64::max);
        assert!(worst < limit, "{worst} {limit}");
        assert_eq!(spline.value(7.0), None);
    }

    #[test]
    fn places_that_do_not_ascend_give_none() {
        assert!(CubicSpline::natural(&[0.0, 1.0, 1.0], &[0.0; 3]).is_none());
        assert!(CubicSpline::natural(&[0.0, 1.0], &[0.0; 2]).is_none());
    }
}
