//! Light and dark levels along the shaft, pooled as far as the frame's own data support.
//!
//! Every column gives the mean of its flat pixels. Means of sixteen columns are fitted by piecewise linear curves with
//! 2, 3, 5, 9, … equidistant knots; the number of knots is the one with the least χ² + 2.5·knots (Mallows' C_p, a little
//! stricter: pooling levels that are not common costs more than it gains, but a knot too many costs little).

/// Columns of a bin.
const BIN: usize = 16;
/// Price of a knot in units of χ².
const KNOT_PRICE: f64 = 2.5;

/// A level along the columns, with the uncertainty that neighbouring columns share.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct LevelCurve {
    /// Level of each column, counts.
    pub(crate) level: Vec<f32>,
    /// Its standard uncertainty, counts, shared by all columns within about `length`.
    pub(crate) uncertainty: Vec<f32>,
    /// Columns over which the uncertainty is shared (distance of the knots).
    pub(crate) length: f32,
}

/// Bins of a series: abscissa in columns, mean, number of columns.
struct Bins {
    at: Vec<f64>,
    mean: Vec<f64>,
    count: Vec<f64>,
}

/// Fits the columns' means (NaN where missing); `sd` is the standard deviation of one column's mean, counts.
/// `None` without any column.
pub(crate) fn pool(means: &[f32], sd: f32, max_knots: usize) -> Option<LevelCurve> {
    let bins = bin(means, sd);
    if bins.at.is_empty() {
        return None;
    }
    let variance = f64::from(sd).powi(2).max(1e-12);
    let mut best: Option<(f64, Fit)> = None;
    let mut knots = 2;
    while knots <= max_knots.max(2) && (knots == 2 || 2 * knots <= bins.at.len()) {
        if let Some((chi2, fit)) = fit_knots(&bins, means.len(), knots, variance) {
            let price = chi2 + KNOT_PRICE * knots as f64;
            if best.as_ref().is_none_or(|(least, _)| price < *least) {
                best = Some((price, fit));
            }
        }
        knots = 2 * knots - 1;
    }
    best.map(|(_, fit)| fit.curve(means.len()))
}

fn bin(means: &[f32], sd: f32) -> Bins {
    let mut bins = Bins { at: Vec::new(), mean: Vec::new(), count: Vec::new() };
    for (index, chunk) in means.chunks(BIN).enumerate() {
        let mut good = [0.0_f32; BIN];
        let mut n = 0;
        for value in chunk.iter().filter(|v| v.is_finite()) {
            good[n] = *value;
            n += 1;
        }
        let good = &mut good[..n];
        let (low, high) =
            good.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        let outside = if high - low > 8.0 * sd { keep_central(good, sd) } else { 0..n };
        let good = &good[outside];
        if !good.is_empty() {
            bins.at.push((index * BIN) as f64 + 0.5 * (chunk.len() as f64 - 1.0));
            bins.mean.push(good.iter().map(|v| f64::from(*v)).sum::<f64>() / good.len() as f64);
            bins.count.push(good.len() as f64);
        }
    }
    bins
}

/// Sorts the values and keeps those within five standard deviations of the median.
fn keep_central(values: &mut [f32], sd: f32) -> std::ops::Range<usize> {
    values.sort_unstable_by(f32::total_cmp);
    let median = values[values.len() / 2];
    let from = values.partition_point(|v| *v < median - 5.0 * sd);
    let to = values.partition_point(|v| *v <= median + 5.0 * sd);
    from..to
}

/// Knot values with the bands of the normal matrix's inverse that neighbouring knots need.
struct Fit {
    knots: Vec<f64>,
    /// Variance of each knot.
    variance: Vec<f64>,
    /// Covariance of a knot with the next one.
    covariance: Vec<f64>,
}

fn fit_knots(bins: &Bins, columns: usize, knots: usize, variance: f64) -> Option<(f64, Fit)> {
    let spacing = (columns.max(2) - 1) as f64 / (knots - 1) as f64;
    let hat = |at: f64| {
        let left = ((at / spacing) as usize).min(knots - 2);
        (left, at / spacing - left as f64)
    };
    let (mut diagonal, mut off, mut right) = (vec![0.0; knots], vec![0.0; knots - 1], vec![0.0; knots]);
    let mut total = 0.0;
    for ((at, mean), count) in bins.at.iter().zip(&bins.mean).zip(&bins.count) {
        let (left, t) = hat(*at);
        let weight = count / variance;
        total += weight;
        diagonal[left] += weight * (1.0 - t) * (1.0 - t);
        diagonal[left + 1] += weight * t * t;
        off[left] += weight * t * (1.0 - t);
        right[left] += weight * (1.0 - t) * mean;
        right[left + 1] += weight * t * mean;
    }
    // Knots without data (a part that ends inside the field) lean on their neighbours with a millionth of a bin's weight.
    let lean = 1e-6 * total / bins.at.len() as f64;
    for k in 0..knots - 1 {
        diagonal[k] += lean;
        diagonal[k + 1] += lean;
        off[k] -= lean;
    }
    let fit = solve_tridiagonal(&diagonal, &off, &right)?;
    let chi2 = bins
        .at
        .iter()
        .zip(&bins.mean)
        .zip(&bins.count)
        .map(|((at, mean), count)| {
            let (left, t) = hat(*at);
            let model = fit.knots[left] * (1.0 - t) + fit.knots[left + 1] * t;
            count / variance * (mean - model).powi(2)
        })
        .sum();
    Some((chi2, fit))
}

/// Solves a symmetric tridiagonal system and gives the two central bands of its inverse (Usmani's recurrences).
fn solve_tridiagonal(diagonal: &[f64], off: &[f64], right: &[f64]) -> Option<Fit> {
    let n = diagonal.len();
    let mut forward = diagonal.to_vec();
    let mut solution = right.to_vec();
    for k in 1..n {
        let factor = off[k - 1] / forward[k - 1];
        forward[k] -= factor * off[k - 1];
        solution[k] -= factor * solution[k - 1];
    }
    if forward.iter().any(|pivot| !(*pivot > 0.0)) {
        return None;
    }
    let mut variance = vec![0.0; n];
    let mut covariance = vec![0.0; n - 1];
    variance[n - 1] = 1.0 / forward[n - 1];
    solution[n - 1] /= forward[n - 1];
    for k in (0..n - 1).rev() {
        let ratio = off[k] / forward[k];
        solution[k] = solution[k] / forward[k] - ratio * solution[k + 1];
        covariance[k] = -ratio * variance[k + 1];
        variance[k] = 1.0 / forward[k] - ratio * covariance[k];
    }
    Some(Fit { knots: solution, variance, covariance })
}

impl Fit {
    fn curve(&self, columns: usize) -> LevelCurve {
        let intervals = self.knots.len() - 1;
        let spacing = (columns.max(2) - 1) as f64 / intervals as f64;
        let mut curve = LevelCurve {
            level: Vec::with_capacity(columns),
            uncertainty: Vec::with_capacity(columns),
            length: spacing as f32,
        };
        for column in 0..columns {
            let at = column as f64 / spacing;
            let left = (at as usize).min(intervals - 1);
            let (t, s) = (at - left as f64, 1.0 - (at - left as f64));
            let level = s * self.knots[left] + t * self.knots[left + 1];
            let variance = s * s * self.variance[left]
                + 2.0 * s * t * self.covariance[left]
                + t * t * self.variance[left + 1];
            curve.level.push(level as f32);
            curve.uncertainty.push(variance.max(0.0).sqrt() as f32);
        }
        curve
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_of_the_inverse_are_those_of_a_dense_inverse() {
        let (d, o) = ([4.0, 3.0, 5.0, 2.0], [1.0, -0.5, 0.7]);
        let fit = solve_tridiagonal(&d, &o, &[1.0, 2.0, 3.0, 4.0]).unwrap();
        let mut dense = nalgebra::DMatrix::<f64>::zeros(4, 4);
        for k in 0..4 {
            dense[(k, k)] = d[k];
            if k < 3 {
                dense[(k, k + 1)] = o[k];
                dense[(k + 1, k)] = o[k];
            }
        }
        let inverse = dense.try_inverse().unwrap();
        let solution = &inverse * nalgebra::DVector::from_vec(vec![1.0, 2.0, 3.0, 4.0]);
        for k in 0..4 {
            assert!((fit.variance[k] - inverse[(k, k)]).abs() < 1e-12);
            assert!((fit.knots[k] - solution[k]).abs() < 1e-12);
            if k < 3 {
                assert!((fit.covariance[k] - inverse[(k, k + 1)]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_line_needs_two_knots_and_a_wave_more() {
        let line: Vec<f32> =
            (0..2048).map(|c| 100.0 + 0.01 * c as f32 + ((c * 37) % 11) as f32 * 0.1).collect();
        let curve = pool(&line, 0.32, 65).unwrap();
        assert!(curve.length > 2000.0);
        assert!((curve.level[1000] - 110.5).abs() < 0.05);
        let wave: Vec<f32> = (0..2048)
            .map(|c| 100.0 + 10.0 * (c as f32 / 100.0).sin() + ((c * 37) % 11) as f32 * 0.1)
            .collect();
        let curve = pool(&wave, 0.32, 65).unwrap();
        assert!(curve.length < 70.0);
        assert!(pool(&[f32::NAN; 20], 1.0, 9).is_none());
    }
}
