//! A straight line through points of which both coordinates are uncertain.
//!
//! ```text
//! minimise Σ (x_i − X_i)²/u(x_i)² + (y_i − a − b·X_i)²/u(y_i)²   over a, b and every X_i
//! ```
//!
//! York, Evensen, Martínez and De Basabe Delgado, Am. J. Phys. 72 (2004) 367, with uncorrelated
//! errors: b is iterated to convergence, u(a) and u(b) are those at the adjusted points. Where all
//! points have one u(x) and one u(y) it is the line of Deming (1943). Exchange of x and y gives the
//! same line.

/// Relative change of the slope at which the iteration ends.
const CONVERGED: f64 = 1e-14;
/// Most iterations; from the ordinary line ten are usual.
const MOST_STEPS: usize = 200;

/// A point and the standard uncertainties of its coordinates, above 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct UncertainPoint {
    pub(crate) x: f64,
    pub(crate) u_x: f64,
    pub(crate) y: f64,
    pub(crate) u_y: f64,
}

/// y = y_mean + b (x − x_mean) with uncorrelated y_mean and b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct UncertainLine {
    /// Weighted mean of the adjusted x.
    pub(crate) middle_x: f64,
    /// The line there.
    pub(crate) middle_y: f64,
    /// Standard uncertainty of that.
    pub(crate) u_middle_y: f64,
    /// Slope b.
    pub(crate) slope: f64,
    /// Standard uncertainty of b.
    pub(crate) u_slope: f64,
    /// Sum of the squared weighted residuals, to be compared with n − 2.
    pub(crate) chi2: f64,
}

impl UncertainLine {
    /// Through three points or more; `None` for fewer, and where they do not determine a slope.
    pub(crate) fn through(points: &[UncertainPoint]) -> Option<Self> {
        if points.len() < 3 {
            return None;
        }
        let mut slope = ordinary(points)?;
        for _ in 0..MOST_STEPS {
            let next = Step::at(points, slope).next_slope(points);
            if !next.is_finite() {
                return None;
            }
            let change = (next - slope).abs();
            slope = next;
            if change <= CONVERGED * slope.abs() {
                break;
            }
        }
        let step = Step::at(points, slope);
        // Adjusted x: their weighted mean and scatter (equations 13d to 13g).
        let weights = || points.iter().map(|p| weight(p, slope));
        let sum: f64 = weights().sum();
        let adjusted = || points.iter().map(|p| step.x_mean + step.beta(p));
        let middle_x = adjusted().zip(weights()).map(|(x, w)| w * x).sum::<f64>() / sum;
        let square: f64 = adjusted().zip(weights()).map(|(x, w)| w * (x - middle_x).powi(2)).sum();
        let chi2 = points.iter().map(|p| {
            let left = p.y - step.y_mean - slope * (p.x - step.x_mean);
            weight(p, slope) * left * left
        });
        Some(Self {
            middle_x,
            middle_y: step.y_mean + slope * (middle_x - step.x_mean),
            u_middle_y: sum.recip().sqrt(),
            slope,
            u_slope: square.recip().sqrt(),
            chi2: chi2.sum(),
        })
    }

    /// The line at x and its standard uncertainty.
    #[cfg(test)]
    pub(crate) fn at(&self, x: f64) -> (f64, f64) {
        let from_middle = x - self.middle_x;
        (self.middle_y + self.slope * from_middle, self.u_middle_y.hypot(from_middle * self.u_slope))
    }
}

/// Slope of the ordinary line, where the iteration begins.
fn ordinary(points: &[UncertainPoint]) -> Option<f64> {
    let n = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), p| (x + p.x / n, y + p.y / n));
    let square: f64 = points.iter().map(|p| (p.x - x).powi(2)).sum();
    let product: f64 = points.iter().map(|p| (p.x - x) * (p.y - y)).sum();
    (square > 0.0).then(|| product / square)
}

/// W = 1/(u_y² + b² u_x²).
fn weight(p: &UncertainPoint, slope: f64) -> f64 {
    (p.u_y * p.u_y + slope * slope * p.u_x * p.u_x).recip()
}

/// Weighted means at a slope.
struct Step {
    slope: f64,
    x_mean: f64,
    y_mean: f64,
}

impl Step {
    fn at(points: &[UncertainPoint], slope: f64) -> Self {
        let sums = points.iter().fold((0.0, 0.0, 0.0), |(w, x, y), p| {
            let own = weight(p, slope);
            (w + own, x + own * p.x, y + own * p.y)
        });
        Self { slope, x_mean: sums.1 / sums.0, y_mean: sums.2 / sums.0 }
    }

    /// Adjusted x of a point less the mean.
    fn beta(&self, p: &UncertainPoint) -> f64 {
        let (u, v) = (p.x - self.x_mean, p.y - self.y_mean);
        weight(p, self.slope) * (u * p.u_y * p.u_y + self.slope * v * p.u_x * p.u_x)
    }

    /// The next slope.
    fn next_slope(&self, points: &[UncertainPoint]) -> f64 {
        let sums = points.iter().fold((0.0, 0.0), |(over, under), p| {
            let w_beta = weight(p, self.slope) * self.beta(p);
            (over + w_beta * (p.y - self.y_mean), under + w_beta * (p.x - self.x_mean))
        });
        sums.0 / sums.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pearson's data with York's weights: York et al. (2004), a = 5.47991022(29497), b =
    /// -0.480533407(57985), chi² = 11.8663.
    #[test]
    fn pearsons_data_with_yorks_weights_give_the_published_line() {
        let x = [0.0, 0.9, 1.8, 2.6, 3.3, 4.4, 5.2, 6.1, 6.5, 7.4];
        let w_x = [1000.0, 1000.0, 500.0, 800.0, 200.0, 80.0, 60.0, 20.0, 1.8, 1.0];
        let y = [5.9, 5.4, 4.4, 4.6, 3.5, 3.7, 2.8, 2.8, 2.4, 1.5];
        let w_y = [1.0, 1.8, 4.0, 8.0, 20.0, 20.0, 70.0, 70.0, 100.0, 500.0];
        let u = |w: f64| w.sqrt().recip();
        let point = |i: usize| UncertainPoint { x: x[i], u_x: u(w_x[i]), y: y[i], u_y: u(w_y[i]) };
        let points: Vec<UncertainPoint> = (0..x.len()).map(point).collect();
        let line = UncertainLine::through(&points).unwrap();
        let (a, u_a) = line.at(0.0);
        assert!((line.slope + 0.480_533_407).abs() < 1e-8, "{line:?}");
        assert!((a - 5.479_910_22).abs() < 1e-7 && (line.chi2 - 11.8663).abs() < 1e-3, "{a} {line:?}");
        assert!((u_a - 0.294_97).abs() < 5e-4 && (line.u_slope - 0.057_985).abs() < 1e-4, "{u_a} {line:?}");
    }

    /// With one u(x) and one u(y) the slope is Deming's closed form, and x and y may be exchanged.
    #[test]
    fn with_equal_uncertainties_it_is_the_line_of_deming() {
        let values = [(1.0, 1.3), (2.0, 1.9), (3.5, 3.9), (5.0, 4.6), (7.0, 7.4)];
        let (u_x, u_y) = (0.2, 0.3);
        let points = values.map(|(x, y)| UncertainPoint { x, u_x, y, u_y });
        let n = 5.0;
        let (mx, my) =
            (values.iter().map(|v| v.0).sum::<f64>() / n, values.iter().map(|v| v.1).sum::<f64>() / n);
        let sum = |f: &dyn Fn(f64, f64) -> f64| values.iter().map(|v| f(v.0 - mx, v.1 - my)).sum::<f64>();
        let (xx, xy, yy) = (sum(&|x, _| x * x), sum(&|x, y| x * y), sum(&|_, y| y * y));
        let ratio = (u_y / u_x) * (u_y / u_x);
        let c = yy - ratio * xx;
        let deming = (c + (c * c + 4.0 * ratio * xy * xy).sqrt()) / (2.0 * xy);
        let line = UncertainLine::through(&points).unwrap();
        assert!((line.slope - deming).abs() < 1e-10, "{} {deming}", line.slope);
        let turned = values.map(|(x, y)| UncertainPoint { x: y, u_x: u_y, y: x, u_y: u_x });
        assert!((UncertainLine::through(&turned).unwrap().slope * line.slope - 1.0).abs() < 1e-10);
        assert_eq!(UncertainLine::through(&points[..2]), None);
    }
}
