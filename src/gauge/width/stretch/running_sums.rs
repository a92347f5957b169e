//! Sums along every second point of a line, so that the fit to a stretch costs the same at any
//! width.
//!
//! Where no column is missing, the powers of t = (x − middle)/half of k points are known: Σt² =
//! k(k + 1)/3(k − 1), Σt⁴ = k(k + 1)(3k² − 7)/15(k − 1)³, odd ones vanish. Their products with the
//! values are differences of running sums about the middle of the line; what these lose by
//! cancellation is 10⁻⁸ of a value over the narrowest stretch of 2048 columns.

use super::fit::{Fit, Points, Sums};
use crate::gauge::width::reused::Reused;

/// Running sums over the points whose index has a parity.
pub(super) struct RunningSums<'a> {
    points: Points<'a>,
    parity: usize,
    /// First index of that parity.
    first: usize,
    /// Middle of the line, px.
    middle: f64,
    /// Value subtracted from all others, px.
    origin: f64,
    /// Σv, Σx·v, Σx²·v, Σsd² before each point.
    sums: Reused<(f64, f64, f64, f64)>,
    /// Whether all of them are numbers.
    finite: bool,
}

impl<'a> RunningSums<'a> {
    /// Of the points of a range; its ends lie in the line.
    pub(super) fn new(points: Points<'a>, range: &std::ops::Range<usize>, parity: usize) -> Self {
        let first = range.start + (range.start + parity) % 2;
        let (low, high) = (points.x[range.start], points.x[range.end - 1]);
        let (middle, origin) = (0.5 * (low + high), points.y[range.start]);
        let mut sum = (0.0, 0.0, 0.0, 0.0);
        let after = (first..range.end).step_by(2).map(|i| {
            let (x, v) = (points.x[i] - middle, points.y[i] - origin);
            sum = (sum.0 + v, sum.1 + x * v, sum.2 + x * x * v, sum.3 + points.sd[i] * points.sd[i]);
            sum
        });
        let sums: Reused<(f64, f64, f64, f64)> = std::iter::once((0.0, 0.0, 0.0, 0.0)).chain(after).collect();
        // A value that is no number would be in all sums after it.
        let finite = sums.last().is_some_and(|(a, b, c, d)| (a + b + c + d).is_finite());
        Self { points, parity, first, middle, origin, sums, finite }
    }

    /// Mean of the points of that parity in `from..to` less `lambda` of its standard uncertainties
    /// by noise; infinite without any, or where a value is no number: then nothing is known.
    pub(super) fn mean_bound(&self, from: usize, to: usize, lambda: f64) -> f64 {
        let first = from + (from + self.parity) % 2;
        if !self.finite || first >= to {
            return f64::INFINITY;
        }
        let (at, count) = ((first - self.first) / 2, (to - first).div_ceil(2));
        let ((v0, .., variance0), (v, .., variance)) = (self.sums[at], self.sums[at + count]);
        self.origin + (v - v0 - lambda * (variance - variance0).max(0.0).sqrt()) / count as f64
    }

    /// The fit to the points of that parity in `from..to`; `None` without any.
    pub(super) fn fit(&self, from: usize, to: usize) -> Option<Fit> {
        let first = from + (from + self.parity) % 2;
        let last = to.checked_sub(1 + (to - 1 + self.parity) % 2).filter(|last| *last >= first)?;
        let (low, high) = (self.points.x[first], self.points.x[last]);
        if !self.finite || high - low != (last - first) as f64 {
            return Fit::new(&self.points, (first..to).step_by(2));
        }
        let count = (last - first) / 2 + 1;
        let at = (first - self.first) / 2;
        let ((v0, xv0, xxv0, variance0), (v, xv, xxv, variance)) = (self.sums[at], self.sums[at + count]);
        let (v, xv, xxv) = (v - v0, xv - xv0, xxv - xxv0);
        let (half, m) = ((0.5 * (high - low)).max(0.5), 0.5 * (low + high) - self.middle);
        let products = [v, (xv - m * v) / half, (xxv - m * (2.0 * xv - m * v)) / (half * half)];
        let n = count as f64;
        Some(Fit::of_sums(&Sums {
            middle: 0.5 * (low + high),
            half,
            origin: self.origin,
            sums: even_powers(n),
            products,
            variance: (variance - variance0) / n,
        }))
    }
}

/// Σtᵏ of n points evenly spaced from −1 to 1, k from 0 to 4; of a single one at 0.
fn even_powers(n: f64) -> [f64; 5] {
    if n < 2.0 {
        return [n, 0.0, 0.0, 0.0, 0.0];
    }
    let (product, steps) = (n * (n + 1.0), n - 1.0);
    let fourth = product * (3.0 * n * n - 7.0) / (15.0 * steps * steps * steps);
    [n, 0.0, product / (3.0 * steps), 0.0, fourth]
}

#[cfg(test)]
mod tests {
    use super::super::fit::Order;
    use super::*;

    /// Running sums give the fit that the points themselves give, at both parities and any width,
    /// with missing columns, too.
    #[test]
    fn a_fit_by_running_sums_is_that_of_the_points() {
        let n = 2000_usize;
        let missing = |i: usize| (700..703).contains(&i) || i == 1200;
        let columns: Vec<usize> = (0..n).filter(|i| !missing(*i)).collect();
        let x: Vec<f64> = columns.iter().map(|c| *c as f64).collect();
        let wave =
            |c: usize| 500.0 + 0.01 * c as f64 + (c as f64 / 40.0).sin() + 0.03 * ((c * 7919) % 13) as f64;
        let y: Vec<f64> = columns.iter().map(|c| wave(*c)).collect();
        let sd: Vec<f64> = columns.iter().map(|c| 0.02 + 1e-5 * *c as f64).collect();
        let points = Points { x: &x, y: &y, sd: &sd };
        for (parity, range) in [(0, 0..x.len()), (1, 0..x.len()), (0, 31..1500), (1, 30..1501)] {
            let sums = RunningSums::new(points, &range, parity);
            for width in [1, 2, 5, 6, 11, 33, 257, 1000] {
                for from in (range.start..range.end - width).step_by(17).chain([range.end - width]) {
                    let to = from + width;
                    let indices = (from + (from + parity) % 2..to).step_by(2);
                    let (found, right) = (sums.fit(from, to), Fit::new(&points, indices));
                    let (Some(found), Some(right)) = (&found, &right) else {
                        assert!(found.is_none() && right.is_none(), "{parity} {width} {from}");
                        assert!(sums.mean_bound(from, to, 1.0) == f64::INFINITY);
                        continue;
                    };
                    let mean = sums.mean_bound(from, to, 1.5) - right.bound(Order::Mean, x[from], 1.5);
                    assert!(mean.abs() < 1e-6, "{parity} {width} {from}: {mean}");
                    for order in [Order::Mean, Order::Line, Order::Parabola] {
                        for (share, lambda) in [(0.0, 0.0), (0.5, 2.0), (1.0, 3.0)] {
                            let at = x[from] + share * (x[to - 1] - x[from]);
                            let (a, b) = (found.bound(order, at, lambda), right.bound(order, at, lambda));
                            assert!((a - b).abs() < 1e-6, "{parity} {width} {from} {order:?}: {a} {b}");
                        }
                    }
                }
            }
        }
    }
}
