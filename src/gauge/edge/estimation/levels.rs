//! Light and dark levels along the shaft, pooled as far as the frame's own data support.
//!
//! Every column gives the mean of its flat pixels. Means of sixteen columns are fitted by piecewise
//! linear curves with 2, 3, 5, 9, … equidistant knots; the number of knots is the one with the
//! least χ² + 4·knots, between Mallows' C_p (2) and Schwarz' criterion (ln of some hundred bins,
//! 5): a knot that noise alone has earned follows that noise by more than its variance implies, and
//! the uncertainty of long means was too small by 3 % at a penalty of 2.5.
//!
//! In a short frame few bins leave few knots, and light that falls along the shaft bends between
//! them. Where χ² shows that, a quartic is subtracted first and added again (P2 to P4 of Legendre,
//! which are orthogonal to the line in an evenly filled field). The residual of the curve of a
//! short frame beyond the noise of its bins widens its uncertainty by √(χ²/ν) (Birge, Phys. Rev. 40
//! (1932) 207).

use crate::gauge::limit::limits;
use crate::numerics::normal_equations::NormalEquations;

limits! {
    /// How many knots a level has, and when its curve does not fit.
    LevelLimits = "levels";
    /// Penalty of a knot in units of χ², or of −2 ln of the likelihood: between Mallows' 2 and
    /// Schwarz' 5 (the module's heading).
    knot_penalty: f64 = 4.0;
    /// χ²/ν from which a curve does not fit its bins: noise reaches it in one of 2000 curves of
    /// eight degrees of freedom.
    excess_chi2: f64 = 3.5;
    /// Bins below which a frame is short: in longer ones knots enough follow the light, and what
    /// they leave is structure (reflections in the shadow), which is no error that neighbouring
    /// columns share.
    short_bins: usize = 64;
}

/// Columns of a bin.
const BIN: usize = 16;

/// A level along the columns, with the uncertainty that neighbouring columns share. Level and
/// uncertainty are columns of equal length: the fit of an edge reads the former alone.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct LevelCurve {
    /// Level of each column, counts.
    pub(crate) level: Vec<f32>,
    /// Its standard uncertainty, counts, shared by all columns within about `length`.
    pub(crate) uncertainty: Vec<f32>,
    /// Columns over which the uncertainty is shared (distance of the knots).
    pub(crate) length: f32,
    /// Mean level, counts.
    pub(crate) mean: f64,
}

/// Neighbouring columns of a series.
#[derive(Clone, Copy, Debug)]
struct Bin {
    /// Their middle, columns.
    at: f64,
    mean: f64,
    /// Their number.
    count: f64,
}

/// Bins of a series, in ascending order.
#[derive(Clone, Debug, Default)]
struct Bins(Vec<Bin>);

/// Pools levels; keeps its memory between frames.
#[derive(Clone, Debug, Default)]
pub(crate) struct LevelPool {
    bins: Bins,
    trial: Fit,
    best: Fit,
}

impl LevelPool {
    /// Fits the columns' means (NaN where missing); `sd` is the standard deviation of one column's
    /// mean, counts. False, with `curve` untouched, without any column.
    pub(crate) fn pool(&mut self, means: &[f32], sd: f32, max_knots: usize, curve: &mut LevelCurve) -> bool {
        let LevelLimits { knot_penalty, excess_chi2, short_bins } = *LevelLimits::get();
        self.bins.fill(means, sd);
        if self.bins.0.is_empty() {
            return false;
        }
        let variance = f64::from(sd).powi(2).max(1e-12);
        self.trial.reserve(max_knots);
        self.best.reserve(max_knots);
        let straight = self.search(means.len(), variance, max_knots);
        let (mut found, mut bend) = (straight, None);
        let short = self.bins.0.len() < short_bins;
        if straight.reduced_chi2 > excess_chi2 && short && max_knots > 2 {
            bend = self.bins.bend(means.len());
            if let Some(bend) = &bend {
                self.bins.add(bend, -1.0);
                found = self.search(means.len(), variance, max_knots);
            }
            if !(found.penalised + 3.0 * knot_penalty < straight.penalised) {
                if let Some(bend) = bend.take() {
                    self.bins.add(&bend, 1.0);
                }
                found = self.search(means.len(), variance, max_knots);
            }
        }
        if !found.penalised.is_finite() {
            return false;
        }
        if found.reduced_chi2 > excess_chi2 && short {
            self.best.widen(found.reduced_chi2);
        }
        self.best.curve(means.len(), curve);
        if let Some(bend) = bend {
            bend.add_to(curve, variance * found.reduced_chi2.max(1.0));
        }
        true
    }

    /// Finds the number of knots with the least penalised χ²; the fit is the best one.
    fn search(&mut self, columns: usize, variance: f64, max_knots: usize) -> Found {
        let penalty = LevelLimits::get().knot_penalty;
        let (mut least, mut reduced_chi2) = (f64::INFINITY, 1.0);
        let (mut knots, mut worse) = (2, 0);
        // Twice as many knots that serve worse twice in a row end the search.
        while knots <= max_knots.max(2) && (knots == 2 || 2 * knots <= self.bins.0.len()) && worse < 2 {
            let chi2 = self.trial.fit(&self.bins, columns, knots, variance);
            let penalised = chi2 + penalty * knots as f64;
            worse = if penalised < least { 0 } else { worse + 1 };
            if penalised < least {
                least = penalised;
                let freedom = self.bins.0.len() as f64 - knots as f64;
                reduced_chi2 = if freedom < 1.0 { 1.0 } else { chi2 / freedom };
                std::mem::swap(&mut self.trial, &mut self.best);
            }
            // Even the best conceivable fit with more knots cannot be of less cost.
            if penalty * (2 * knots - 1) as f64 > least {
                break;
            }
            knots = 2 * knots - 1;
        }
        Found { penalised: least, reduced_chi2 }
    }
}

/// Result of a search for the number of knots.
#[derive(Clone, Copy, Debug)]
struct Found {
    /// χ² + penalty of the knots.
    penalised: f64,
    /// χ² a degree of freedom.
    reduced_chi2: f64,
}

/// A bend of the level: a2 P2(t) + a3 P3(t) + a4 P4(t), t from −1 to 1 along the columns.
#[derive(Clone, Copy, Debug)]
struct Bend {
    by: [f64; 3],
    columns: usize,
    /// Columns that show it.
    count: f64,
}

/// Legendre's polynomials of second to fourth order at a column.
fn legendre(column: f64, columns: usize) -> [f64; 3] {
    let t = 2.0 * column / (columns.max(2) - 1) as f64 - 1.0;
    let s = t * t;
    [0.5 * (3.0 * s - 1.0), 0.5 * t * (5.0 * s - 3.0), 0.125 * ((35.0 * s - 30.0) * s + 3.0)]
}

impl Bend {
    fn at(&self, column: f64) -> f64 {
        legendre(column, self.columns).iter().zip(self.by).map(|(p, by)| p * by).sum()
    }

    /// Adds the bend and its uncertainty to a curve; `variance` is that of one column's mean.
    fn add_to(&self, curve: &mut LevelCurve, variance: f64) {
        for (column, (level, u)) in curve.level.iter_mut().zip(&mut curve.uncertainty).enumerate() {
            let [p2, p3, p4] = legendre(column as f64, self.columns);
            *level += self.at(column as f64) as f32;
            // Mean squares of P2, P3 and P4 over the field are 1/5, 1/7 and 1/9.
            let bend = variance / self.count * (5.0 * p2 * p2 + 7.0 * p3 * p3 + 9.0 * p4 * p4);
            *u = (f64::from(*u).powi(2) + bend).sqrt() as f32;
        }
    }
}

impl Bins {
    fn fill(&mut self, means: &[f32], sd: f32) {
        self.0.clear();
        for (index, chunk) in means.chunks(BIN).enumerate() {
            if let Some(sum) = clean_sum(chunk, 8.0 * sd) {
                self.push(index, chunk.len(), sum, BIN);
                continue;
            }
            let kept = Kept::of(chunk, sd);
            if kept.count > 0 {
                self.push(index, chunk.len(), kept.sum, kept.count);
            }
        }
    }

    /// The quartic of least squares over all bins, without its constant and line; `None` where few
    /// bins show it.
    fn bend(&self, columns: usize) -> Option<Bend> {
        let mut fit = NormalEquations::new();
        for Bin { at, mean, count } in &self.0 {
            let [p2, p3, p4] = legendre(*at, columns);
            let t = 2.0 * at / (columns.max(2) - 1) as f64 - 1.0;
            fit.add(nalgebra::Vector5::new(1.0, t, p2, p3, p4), *mean, *count);
        }
        if self.0.len() < 7 {
            return None;
        }
        let by = fit.by_cholesky()?;
        Some(Bend { by: [by[2], by[3], by[4]], columns, count: self.0.iter().map(|bin| bin.count).sum() })
    }

    /// Adds a bend so many times.
    fn add(&mut self, bend: &Bend, times: f64) {
        for bin in &mut self.0 {
            bin.mean += times * bend.at(bin.at);
        }
    }

    fn push(&mut self, index: usize, length: usize, sum: f32, count: usize) {
        let at = (index * BIN) as f64 + 0.5 * (length as f64 - 1.0);
        self.0.push(Bin { at, mean: f64::from(sum) / count as f64, count: count as f64 });
    }
}

/// Sum of a whole bin without a missing value or an outlier; `None` where there is one.
fn clean_sum(chunk: &[f32], widest: f32) -> Option<f32> {
    let values: &[f32; BIN] = chunk.try_into().ok()?;
    let (mut sums, mut low, mut high) = ([0.0_f32; 4], [f32::INFINITY; 4], [f32::NEG_INFINITY; 4]);
    for four in values.as_chunks::<4>().0 {
        for lane in 0..4 {
            sums[lane] += four[lane];
            low[lane] = if four[lane] < low[lane] { four[lane] } else { low[lane] };
            high[lane] = if four[lane] > high[lane] { four[lane] } else { high[lane] };
        }
    }
    let sum = (sums[0] + sums[2]) + (sums[1] + sums[3]);
    let least = low.iter().fold(f32::INFINITY, |l, v| if *v < l { *v } else { l });
    let most = high.iter().fold(f32::NEG_INFINITY, |h, v| if *v > h { *v } else { h });
    (sum.is_finite() && most - least <= widest).then_some(sum)
}

/// The values kept of a bin with missing values or outliers.
struct Kept {
    sum: f32,
    count: usize,
}

impl Kept {
    /// Keeps the values within five standard deviations of the line through the medians of the
    /// bin's halves: along a shaft the light may fall off by more than that over sixteen columns.
    /// What is taken off a line is added again at the bin's middle.
    fn of(chunk: &[f32], sd: f32) -> Self {
        let (left, right) = chunk.split_at(chunk.len() / 2);
        let halves = [median_of_finite(left), median_of_finite(right)];
        let (middle, slope) = match halves {
            [Some(a), Some(b)] => (0.5 * (a + b), (b - a) / (0.5 * chunk.len() as f32)),
            [Some(one), None] | [None, Some(one)] => (one, 0.0),
            [None, None] => return Self { sum: 0.0, count: 0 },
        };
        let mut kept = Self { sum: 0.0, count: 0 };
        for (column, value) in chunk.iter().enumerate() {
            let level = value - slope * (column as f32 - 0.5 * (chunk.len() as f32 - 1.0));
            if (level - middle).abs() <= 5.0 * sd {
                kept.sum += level;
                kept.count += 1;
            }
        }
        kept
    }
}

/// Median of the values that are not missing: the mean of the two middle ones where their number is
/// even.
fn median_of_finite(values: &[f32]) -> Option<f32> {
    let mut good = [0.0_f32; BIN];
    let mut n = 0;
    for value in values.iter().filter(|v| v.is_finite()) {
        good[n] = *value;
        n += 1;
    }
    let good = &mut good[..n];
    good.sort_unstable_by(f32::total_cmp);
    (n > 0).then(|| 0.5 * (good[(n - 1) / 2] + good[n / 2]))
}

/// A knot with its row of the normal equations; what concerns the next knot is zero in the last.
#[derive(Clone, Copy, Debug, Default)]
struct Knot {
    /// Right-hand side, then the knot's value.
    value: f64,
    variance: f64,
    /// Covariance with the next knot.
    covariance: f64,
    diagonal: f64,
    /// Entry of the normal matrix between this knot and the next.
    off: f64,
    /// Right-hand side, kept.
    right: f64,
}

/// Knots with the bands of the normal matrix's inverse that neighbouring ones need.
#[derive(Clone, Debug, Default)]
struct Fit {
    knots: Vec<Knot>,
}

impl Fit {
    /// Makes room for so many knots.
    fn reserve(&mut self, knots: usize) {
        self.knots.reserve(knots.saturating_sub(self.knots.len()));
    }

    /// Weighted least squares with so many knots; returns χ², infinite where the knots are not
    /// determined.
    fn fit(&mut self, bins: &Bins, columns: usize, knots: usize, variance: f64) -> f64 {
        let per_spacing = (knots - 1) as f64 / (columns.max(2) - 1) as f64;
        self.knots.clear();
        self.knots.resize(knots, Knot::default());
        let (mut total, mut squares) = (0.0, 0.0);
        // Means relative to the first: χ² is a small difference of large sums.
        let origin = bins.0[0].mean;
        let (mut left, mut end) = (0, 1.0 / per_spacing);
        for Bin { at, mean, count } in &bins.0 {
            // Bins ascend: the interval is never behind.
            while *at >= end && left + 2 < knots {
                left += 1;
                end = (left + 1) as f64 / per_spacing;
            }
            let t = at * per_spacing - left as f64;
            let (s, mean) = (1.0 - t, mean - origin);
            total += count;
            squares += count * mean * mean;
            self.knots[left].diagonal += count * s * s;
            self.knots[left + 1].diagonal += count * t * t;
            self.knots[left].off += count * t * s;
            self.knots[left].value += count * s * mean;
            self.knots[left + 1].value += count * t * mean;
        }
        // Knots without data (a part that ends inside the field) lean on their neighbours with a
        // millionth of a bin's weight. One bin alone (readings of a line camera) states nothing of
        // a slope: its knots stand at one level.
        let weight = if bins.0.len() == 1 { 1e3 } else { 1e-6 };
        let lean = weight * total / bins.0.len() as f64;
        for k in 0..knots - 1 {
            self.knots[k].diagonal += lean;
            self.knots[k + 1].diagonal += lean;
            self.knots[k].off -= lean;
        }
        // Only the weights' ratio matters to the knots; their covariance takes the variance.
        self.knots.iter_mut().for_each(|knot| knot.right = knot.value);
        if !self.solve() {
            return f64::INFINITY;
        }
        self.widen(variance);
        // Σ r² = Σ m² − kᵀb − kᵀLk, where L is what leans.
        let explained: f64 = self.knots.iter().map(|knot| knot.value * knot.right).sum();
        let leaning: f64 = self.knots.windows(2).map(|w| (w[1].value - w[0].value).powi(2)).sum();
        self.knots.iter_mut().for_each(|knot| knot.value += origin);
        (squares - explained - lean * leaning).max(0.0) / variance
    }

    /// Multiplies variances and covariances.
    fn widen(&mut self, times: f64) {
        for knot in &mut self.knots {
            knot.variance *= times;
            knot.covariance *= times;
        }
    }

    /// Solves the symmetric tridiagonal system (right-hand side in `value`) and gives the two
    /// central bands of its inverse (Usmani's recurrences); false where it is singular.
    fn solve(&mut self) -> bool {
        let knots = &mut self.knots;
        let n = knots.len();
        for k in 1..n {
            let before = knots[k - 1];
            let factor = before.off / before.diagonal;
            knots[k].diagonal -= factor * before.off;
            knots[k].value -= factor * before.value;
        }
        if knots.iter().any(|knot| !(knot.diagonal > 0.0)) {
            return false;
        }
        let last = &mut knots[n - 1];
        last.variance = 1.0 / last.diagonal;
        last.value /= last.diagonal;
        for k in (0..n - 1).rev() {
            let next = knots[k + 1];
            let knot = &mut knots[k];
            let pivot = 1.0 / knot.diagonal;
            let ratio = knot.off * pivot;
            knot.value = knot.value * pivot - ratio * next.value;
            knot.covariance = -ratio * next.variance;
            knot.variance = pivot - ratio * knot.covariance;
        }
        true
    }

    /// Level and variance at a column.
    fn at(&self, column: f64, per_spacing: f64) -> (f64, f64) {
        let left = ((column * per_spacing) as usize).min(self.knots.len() - 2);
        let t = column * per_spacing - left as f64;
        let s = 1.0 - t;
        let (a, b) = (&self.knots[left], &self.knots[left + 1]);
        let variance = s * s * a.variance + 2.0 * s * t * a.covariance + t * t * b.variance;
        (s * a.value + t * b.value, variance)
    }

    /// Evaluates the curve: exactly at the ends of bins, linearly in between (bins are no longer
    /// than half a knot's distance).
    fn curve(&self, columns: usize, curve: &mut LevelCurve) {
        let per_spacing = (self.knots.len() - 1) as f64 / (columns.max(2) - 1) as f64;
        curve.length = (1.0 / per_spacing) as f32;
        curve.level.resize(columns, 0.0);
        curve.uncertainty.resize(columns, 0.0);
        let (mut left, _) = self.at(0.0, per_spacing);
        let mut sum = 0.0;
        let chunks = curve.level.chunks_mut(BIN).zip(curve.uncertainty.chunks_mut(BIN));
        for (index, (levels, uncertainties)) in chunks.enumerate() {
            let (right, variance) = self.at((index * BIN + levels.len()) as f64, per_spacing);
            let step = ((right - left) / levels.len() as f64) as f32;
            uncertainties.fill(variance.max(0.0).sqrt() as f32);
            for (k, level) in levels.iter_mut().enumerate() {
                *level = left as f32 + k as f32 * step;
            }
            sum += levels.len() as f64 * 0.5 * (left + right) - 0.5 * (right - left);
            left = right;
        }
        curve.mean = sum / columns.max(1) as f64;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_of_the_inverse_are_those_of_a_dense_inverse() {
        let (d, o) = ([4.0, 3.0, 5.0, 2.0], [1.0, -0.5, 0.7]);
        let row = |k: usize| Knot {
            value: 1.0 + k as f64,
            diagonal: d[k],
            off: o.get(k).copied().unwrap_or(0.0),
            ..Knot::default()
        };
        let mut fit = Fit { knots: (0..4).map(row).collect() };
        assert!(fit.solve());
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
            assert!((fit.knots[k].variance - inverse[(k, k)]).abs() < 1e-12);
            assert!((fit.knots[k].value - solution[k]).abs() < 1e-12);
            if k < 3 {
                assert!((fit.knots[k].covariance - inverse[(k, k + 1)]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_steep_fall_of_the_light_moves_no_level() {
        // From 100 to 40 counts over 96 columns: 10 counts a bin, where a column's level is known
        // to half a count.
        let fall: Vec<f32> =
            (0..96).map(|c| 100.0 - 0.625 * c as f32 + ((c * 37) % 11) as f32 * 0.1 - 0.5).collect();
        let (mut curve, mut pool) = (LevelCurve::default(), LevelPool::default());
        assert!(pool.pool(&fall, 0.5, 33, &mut curve));
        for column in [5, 48, 90] {
            let expected = 100.0 - 0.625 * column as f32;
            assert!((curve.level[column] - expected).abs() < 0.15, "{column}: {}", curve.level[column]);
        }
    }

    #[test]
    fn light_that_bends_along_a_short_frame_lies_within_its_uncertainty() {
        type Light = fn(f64) -> f64;
        let lights: [Light; 3] = [
            |c| 200.0 * (-c / 115.0).exp(),
            |c| 180.0 * (-((c - 60.0) / 110.0).powi(2)).exp(),
            |c| 60.0 + 0.9 * c,
        ];
        for (k, light) in lights.into_iter().enumerate() {
            let means: Vec<f32> =
                (0..160).map(|c| (light(f64::from(c)) + ((c * 37) % 11) as f64 * 0.1 - 0.5) as f32).collect();
            let (mut curve, mut pool) = (LevelCurve::default(), LevelPool::default());
            assert!(pool.pool(&means, 0.32, 65, &mut curve));
            for column in (0..160).step_by(5) {
                let miss = f64::from(curve.level[column]) - light(column as f64);
                let u = f64::from(curve.uncertainty[column]);
                // A level wrong by .2 % moves an edge by .002 px, less than such frames show; five
                // knots alone miss by 1 %.
                assert!(
                    miss.abs() < 3.0 * u + 0.002 * light(column as f64) && u < 0.8,
                    "light {k}, column {column}: {miss:.3} u {u:.3}"
                );
            }
        }
    }

    #[test]
    fn a_line_needs_two_knots_and_a_wave_more() {
        let line: Vec<f32> =
            (0..2048).map(|c| 100.0 + 0.01 * c as f32 + ((c * 37) % 11) as f32 * 0.1).collect();
        let (mut curve, mut pool) = (LevelCurve::default(), LevelPool::default());
        assert!(pool.pool(&line, 0.32, 65, &mut curve));
        assert!(curve.length > 2000.0);
        assert!((curve.level[1000] - 110.5).abs() < 0.05);
        let wave: Vec<f32> = (0..2048)
            .map(|c| 100.0 + 10.0 * (c as f32 / 100.0).sin() + ((c * 37) % 11) as f32 * 0.1)
            .collect();
        assert!(pool.pool(&wave, 0.32, 65, &mut curve));
        assert!(curve.length < 70.0);
        assert!(!pool.pool(&[f32::NAN; 20], 1.0, 9, &mut curve));
    }
}
