//! Polynomials through the values of a stretch of columns, with the change by the next orders.

use crate::gauge::limit::limits;
use nalgebra::{Matrix3, Vector3};

limits! {
    /// When a line or parabola describes its stretch.
    StretchFitLimits = "stretch_fit";
    /// Standard deviations of χ² up to which it does: 2.3 % of good ones are left out, and others
    /// nearby take their place.
    chi2: f64 = 2.0;
    /// The same of the covariance of neighbouring residuals: 10 % of good ones are left out.
    lag: f64 = 1.3;
}

/// Values along a line of columns, each with the standard deviation of its noise.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Points<'a> {
    /// Columns, px, rising.
    pub(crate) x: &'a [f64],
    /// Values, px.
    pub(crate) y: &'a [f64],
    /// Standard deviations, px.
    pub(crate) sd: &'a [f64],
}

/// What represents a stretch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Order {
    /// Its mean: never above the largest value in it.
    Mean,
    /// The end of a line through it.
    Line,
    /// The vertex of a parabola through it.
    Parabola,
}

/// A value of a fit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Estimate {
    /// Value, px.
    pub(crate) value: f64,
    /// Its standard uncertainty by noise, px.
    pub(super) u_noise: f64,
    /// By how much the next two orders would lower it, beyond their noise, px.
    pub(crate) excess: f64,
}

/// Least-squares fits to one stretch; abscissa t = (x − middle)/half length.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    n: f64,
    middle: f64,
    half: f64,
    /// A value near all others, subtracted so that sums keep their digits.
    origin: f64,
    sums: [f64; 5],
    products: [f64; 3],
    /// Mean variance of a value's noise, px².
    variance: f64,
    line: (f64, f64),
    parabola: Option<(Vector3<f64>, Matrix3<f64>)>,
}

/// What a fit is computed from.
pub(super) struct Sums {
    /// Middle of the points, px, and half of their length.
    pub(super) middle: f64,
    pub(super) half: f64,
    /// Value subtracted from all others, px.
    pub(super) origin: f64,
    /// Σtᵏ, k from 0 to 4.
    pub(super) sums: [f64; 5],
    /// Σtᵏ·v, k from 0 to 2.
    pub(super) products: [f64; 3],
    /// Mean variance of a value's noise, px².
    pub(super) variance: f64,
}

/// Residuals about a fit.
struct Residuals {
    square: f64,
    /// Sum of the products of neighbours.
    lag: f64,
    /// Coefficients of the Legendre polynomials 2, 3 and 4 in them, and the sums of these
    /// polynomials' squares.
    coefficients: [f64; 3],
    norms: [f64; 3],
}

/// Legendre polynomials 2, 3 and 4.
fn legendre(t: f64) -> [f64; 3] {
    let t2 = t * t;
    [1.5 * t2 - 0.5, t * (2.5 * t2 - 1.5), (t2 * (35.0 * t2 - 30.0) + 3.0) / 8.0]
}

impl Fit {
    /// Fits the points of some indices; `None` without any.
    pub(crate) fn new(points: &Points<'_>, indices: impl Iterator<Item = usize> + Clone) -> Option<Self> {
        let first = indices.clone().next()?;
        let last = indices.clone().last()?;
        let (low, high) = (points.x[first], points.x[last]);
        let (middle, half, origin) = (0.5 * (low + high), (0.5 * (high - low)).max(0.5), points.y[first]);
        let (mut sums, mut products, mut variance) = ([0.0; 5], [0.0; 3], 0.0);
        for i in indices {
            let (t, v) = ((points.x[i] - middle) / half, points.y[i] - origin);
            let t2 = t * t;
            for (sum, power) in sums.iter_mut().zip([1.0, t, t2, t * t2, t2 * t2]) {
                *sum += power;
            }
            for (sum, power) in products.iter_mut().zip([1.0, t, t2]) {
                *sum += power * v;
            }
            variance += points.sd[i] * points.sd[i];
        }
        let variance = variance / sums[0];
        Some(Self::of_sums(&Sums { middle, half, origin, sums, products, variance }))
    }

    /// The fit that has these sums.
    pub(super) fn of_sums(of: &Sums) -> Self {
        let Sums { middle, half, origin, sums, products, variance } = *of;
        let n = sums[0];
        let line = (products[0] / n, 0.0);
        let mut fit = Self { n, middle, half, origin, sums, products, variance, line, parabola: None };
        fit.solve();
        fit
    }

    fn solve(&mut self) {
        let (s, p) = (&self.sums, &self.products);
        let determinant = self.n * s[2] - s[1] * s[1];
        if determinant > 1e-9 {
            let slope = (self.n * p[1] - s[1] * p[0]) / determinant;
            self.line = ((p[0] - slope * s[1]) / self.n, slope);
        }
        if self.n > 3.0 && s[1] == 0.0 && s[3] == 0.0 {
            // Evenly spaced points: the odd power stands apart.
            let apart = self.n * s[4] - s[2] * s[2];
            let (a, b, c) = (s[4] / apart, s[2] / apart, self.n / apart);
            let inverse = Matrix3::new(a, 0.0, -b, 0.0, s[2].recip(), 0.0, -b, 0.0, c);
            self.parabola = Some((inverse * Vector3::from(*p), inverse));
        } else if self.n > 3.0 {
            let normal = Matrix3::new(s[0], s[1], s[2], s[1], s[2], s[3], s[2], s[3], s[4]);
            let inverse = normal.try_inverse();
            self.parabola = inverse.map(|inverse| (inverse * Vector3::from(*p), inverse));
        }
    }

    /// Column of the parabola's vertex, where it is a maximum well inside the stretch.
    pub(crate) fn vertex(&self) -> Option<f64> {
        let (c, _) = self.parabola.as_ref().filter(|(c, _)| c[2] < 0.0)?;
        let t = -0.5 * c[1] / c[2];
        (t.abs() < 0.8).then_some(self.middle + t * self.half)
    }

    /// Value and variance by noise at a column.
    fn at(&self, order: Order, x: f64) -> (f64, f64) {
        let t = (x - self.middle) / self.half;
        let (value, factor) = match (order, &self.parabola) {
            (Order::Mean, _) => (self.products[0] / self.n, 1.0 / self.n),
            (Order::Parabola, Some((c, inverse))) => {
                let basis = Vector3::new(1.0, t, t * t);
                (c.dot(&basis), (inverse * basis).dot(&basis))
            }
            _ => {
                let mean = self.sums[1] / self.n;
                let spread = (self.sums[2] - self.n * mean * mean).max(1e-9);
                (self.line.0 + self.line.1 * t, 1.0 / self.n + (t - mean).powi(2) / spread)
            }
        };
        (self.origin + value, self.variance * factor)
    }

    /// Value at a column less `lambda` standard uncertainties by noise: the most that its score can
    /// be.
    pub(crate) fn bound(&self, order: Order, x: f64, lambda: f64) -> f64 {
        let (value, variance) = self.at(order, x);
        value - lambda * variance.sqrt()
    }

    /// The estimate at a column, with its uncertainty from the residuals.
    pub(crate) fn estimate(
        &self,
        order: Order,
        x: f64,
        points: &Points<'_>,
        indices: impl Iterator<Item = usize>,
    ) -> Estimate {
        let (value, variance) = self.at(order, x);
        let excess = match order {
            Order::Mean => 0.0,
            _ => self.excess(order, x, &self.residuals(order, points, indices)),
        };
        Estimate { value, u_noise: variance.sqrt(), excess }
    }

    /// Whether the residuals of a line or parabola are noise.
    pub(crate) fn describes(
        &self,
        order: Order,
        points: &Points<'_>,
        indices: impl Iterator<Item = usize>,
    ) -> bool {
        let limits = StretchFitLimits::get();
        let fitted = match order {
            Order::Mean => return true,
            Order::Line => 2.0,
            Order::Parabola => 3.0,
        };
        let residuals = self.residuals(order, points, indices);
        let freedom = (self.n - fitted).max(0.5);
        residuals.square <= self.variance * (freedom + limits.chi2 * (2.0 * freedom).sqrt())
            && residuals.lag <= self.variance * limits.lag * self.n.sqrt()
    }

    /// Change of the value at a column by the next two orders, beyond noise.
    fn excess(&self, order: Order, x: f64, residuals: &Residuals) -> f64 {
        let t = (x - self.middle) / self.half;
        let from = if order == Order::Line { 0 } else { 1 };
        let polynomials = legendre(t);
        let (mut over, mut variance) = (0.0, 0.0);
        for (k, polynomial) in polynomials.iter().enumerate().skip(from).take(2) {
            over -= residuals.coefficients[k] * polynomial;
            variance += self.variance * polynomial.powi(2) / residuals.norms[k].max(1e-9);
        }
        if over > 0.0 { (over * over - variance).max(0.0).sqrt() } else { 0.0 }
    }

    fn residuals(
        &self,
        order: Order,
        points: &Points<'_>,
        indices: impl Iterator<Item = usize>,
    ) -> Residuals {
        let mut out = Residuals { square: 0.0, lag: 0.0, coefficients: [0.0; 3], norms: [0.0; 3] };
        let mut last = 0.0;
        for i in indices {
            let t = (points.x[i] - self.middle) / self.half;
            let residual = points.y[i] - self.at(order, points.x[i]).0;
            out.square += residual * residual;
            out.lag += residual * last;
            last = residual;
            for (k, p) in legendre(t).into_iter().enumerate() {
                out.coefficients[k] += residual * p;
                out.norms[k] += p * p;
            }
        }
        for (coefficient, norm) in out.coefficients.iter_mut().zip(out.norms) {
            *coefficient /= norm.max(1e-9);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_and_a_parabola_give_back_themselves_and_their_uncertainty() {
        let x: Vec<f64> = (0..41).map(f64::from).collect();
        let sd = vec![0.1; 41];
        let straight: Vec<f64> = x.iter().map(|x| 90.0 + 0.02 * x).collect();
        let points = Points { x: &x, y: &straight, sd: &sd };
        let fit = Fit::new(&points, 0..41).unwrap();
        let end = fit.estimate(Order::Line, 40.0, &points, 0..41);
        // Variance of a line's end of n points: 2(2n − 1)/(n(n + 1))·σ².
        let u = 0.1 * (2.0 * 81.0 / (41.0 * 42.0_f64)).sqrt();
        assert!((end.value - 90.8).abs() < 1e-9 && (end.u_noise / u - 1.0).abs() < 1e-9 && end.excess == 0.0);
        let bent: Vec<f64> = x.iter().map(|x| 90.0 - 0.001 * (x - 17.0).powi(2)).collect();
        let points = Points { x: &x, y: &bent, sd: &sd };
        let fit = Fit::new(&points, 0..41).unwrap();
        let top = fit.vertex().unwrap();
        assert!((top - 17.0).abs() < 1e-6);
        assert!((fit.estimate(Order::Parabola, top, &points, 0..41).value - 90.0).abs() < 1e-9);
    }

    /// A line over half of a step ends above it: its residuals show that it does not describe the
    /// stretch.
    #[test]
    fn a_line_across_a_step_does_not_describe_it() {
        let x: Vec<f64> = (0..40).map(f64::from).collect();
        let sd = vec![0.02; 40];
        let step: Vec<f64> = x.iter().map(|x| if *x < 20.0 { 90.0 } else { 90.2 }).collect();
        let points = Points { x: &x, y: &step, sd: &sd };
        let fit = Fit::new(&points, 0..40).unwrap();
        assert!(fit.estimate(Order::Line, 39.0, &points, 0..40).value > 90.22);
        assert!(!fit.describes(Order::Line, &points, 0..40));
        assert!(fit.describes(Order::Mean, &points, 0..40));
    }
}
