//! The largest value over every stretch of a line of columns, down to a least width, without the
//! upward bias of a maximum of noise.
//!
//! A stretch is represented by its mean (a collar, a cylinder), by the end of a line through it
//! where the part or the field ends (a taper), or by the vertex of a parabola (a bump, a wave, a
//! barrel). Of all stretches of all widths the one with the largest value less λ standard
//! uncertainties is chosen: a narrow one only where noise does not explain that it is larger than a
//! wide one. Every other column chooses and the columns between measure, then the other way round,
//! and the mean of both is the value: it is independent of the choice. Where both choose different
//! places, what they differ by beyond noise is stated.

use super::fit::{Estimate, Fit, Order, Points};
use super::running_sums::RunningSums;
use crate::gauge::limit::limits;
use crate::gauge::width::reused::Reused;

limits! {
    /// Which stretch has the largest value.
    LargestValueLimits = "largest_value";
    /// Widest mean, columns: the largest diameter is a local size, and wider stretches are lines or
    /// parabolas.
    widest_mean: usize = 65;
    /// Fewest columns of a line's stretch: each half of them, which chooses or measures, has four
    /// points.
    least_of_line: usize = 9;
    /// Fewest columns of a parabola's stretch: a point more in each half.
    least_of_parabola: usize = 11;
    /// λ over √(2 ln(2n/w)), about the largest of n/w independent normal deviates. At 1 plain
    /// cylinders are given by stretches of 17 columns and more, so that u hardly changes from frame
    /// to frame; at 0.9 bumps of one to two standard deviations on five columns are found more
    /// often, and u of a cylinder is larger by a quarter.
    choice: f64 = 1.0;
    /// Share of the stretch chosen over which a line or parabola is fitted to measure: what the
    /// chosen width leaves of the next orders, as much as noise, falls by its square and its fourth
    /// power.
    measured: f64 = 0.7;
    /// Width, columns, whose mean is as uncertain as what noise may hide between wider stretches:
    /// that which plain cylinders are given by (`choice`).
    hidden: f64 = 17.0;
    /// Columns that may be missing inside a stretch before it ends there. Tuned: see study limits.
    bridge_px: f64 = 8.0;
    /// Drop beside a stretch, in standard deviations of a column, above which it ends at a
    /// shoulder: that of two means of four, 0.7 of a column's, eleven times.
    shoulder: f64 = 8.0;
    /// Such a drop, px, at least: a wave that turns down by less may pass for one, and a line to
    /// its crest would end above it.
    shoulder_px: f64 = 1.0;
    /// Departure from the median of five neighbours, in standard deviations, above which one column
    /// alone is no stretch of the part: noise has one in 10⁷, since the median of the other four
    /// adds half of its own.
    speck: f64 = 6.0;
    /// Ratio of the scatter's estimates by a quarter and by half of the differences, below which
    /// corners of the outline raise the latter. Noise gives 1, from n independent differences to
    /// 1.5/√n (of two quantiles of |z|): of 128 to 0.13, a third of what is left to 1.
    corners: f64 = 0.6;
    /// Scale of the columns' scatter over their stated noise, at least: a median of fourth
    /// differences may be small by chance.
    least_scatter: f64 = 0.5;
}

/// Least width of a stretch where none is stated, columns.
pub(crate) const LEAST_STRETCH: usize = 5;
/// Widths tried, each wider by a quarter to two thirds: of a stretch in between the mean or line
/// over the next narrower one has a u that is larger by less than a third.
const WIDTHS: [usize; 12] = [5, 7, 9, 13, 17, 25, 33, 45, 65, 105, 165, 257];

/// A line of columns. Its values are vectors of equal length: a fit reads size or value shown, each
/// as a slice.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    /// Columns, px.
    pub(super) x: Reused<f64>,
    /// What is to be largest, px.
    size: Reused<f64>,
    /// What is to be given there, px.
    shown: Reused<f64>,
    /// Standard deviation of each by the scatter of its neighbours, px.
    sd: Reused<f64>,
    /// Scatter over the stated noise.
    scatter: f64,
}

/// The largest value over a line's stretches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Largest {
    /// Value, px.
    pub(crate) value_px: f64,
    /// Standard uncertainty by the columns' scatter and by the choice, px.
    pub(crate) u_px: f64,
    /// The part of it that the stated noise of the columns explains, px.
    pub(crate) u_noise_px: f64,
    /// Where it stands, px.
    pub(crate) column_px: f64,
    /// First and last column of the stretch.
    pub(crate) columns: (usize, usize),
}

/// Rounding of a mean by running sums, px: far below any uncertainty, far above 10⁻¹⁰ of a value.
const ROUNDING: f64 = 1e-6;

/// Whether a line ends at a point towards lower and towards higher columns.
type Ends = (bool, bool);

/// A stretch chosen: points `from..to`, and where on it the value stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Choice {
    from: usize,
    to: usize,
    order: Order,
    at: f64,
    pub(super) score: f64,
}

impl Line {
    /// A line of points (column, size, value shown, standard deviation by the stated noise); single
    /// specks are left out.
    pub(crate) fn new(points: &[(f64, f64, f64, f64)]) -> Self {
        let limits = LargestValueLimits::get();
        let size: Reused<f64> = points.iter().map(|p| p.1).collect();
        let noise: Reused<f64> = points.iter().map(|p| p.3).collect();
        let scatter = scatter(&size, &noise);
        let kept: Reused<usize> =
            (0..points.len()).filter(|i| !is_speck(&size, *i, limits.speck * scatter * noise[*i])).collect();
        let of = |value: &dyn Fn(usize) -> f64| kept.iter().map(|i| value(*i)).collect();
        Self {
            x: of(&|i| points[i].0),
            size: of(&|i| size[i]),
            shown: of(&|i| points[i].2),
            sd: of(&|i| scatter * noise[i]),
            scatter,
        }
    }

    /// Number of points.
    pub(crate) fn len(&self) -> usize {
        self.x.len()
    }

    /// The largest value over stretches of `least` columns or more within `range`; `None` without a
    /// point.
    pub(crate) fn largest(&self, range: std::ops::Range<usize>, least: usize) -> Option<Largest> {
        let choices = [0, 1].map(|parity| self.choose(&range, least, parity));
        let [Some(a), Some(b)] = choices else { return None };
        self.measured([a, b])
    }

    /// Estimates of two choices by the halves that did not make them.
    pub(super) fn measured(&self, choices: [Choice; 2]) -> Option<Largest> {
        let limits = LargestValueLimits::get();
        let [Some(a), Some(b)] = [0, 1].map(|parity| self.measure(&choices[parity], parity)) else {
            return None;
        };
        let noise = 0.25 * (a.u_noise * a.u_noise + b.u_noise * b.u_noise);
        let apart = 0.25 * (a.value - b.value).powi(2) - noise;
        let narrower = choices.iter().map(|c| c.to - c.from).min().unwrap_or(0);
        let sd = self.sd[choices[0].from];
        let hidden = if narrower as f64 > limits.hidden { sd * sd / limits.hidden } else { 0.0 };
        let excess = 0.5 * (a.excess + b.excess);
        let better = &choices[usize::from(choices[1].score > choices[0].score)];
        Some(Largest {
            value_px: 0.5 * (a.value + b.value),
            u_px: (noise + apart.max(hidden) + excess * excess).sqrt(),
            u_noise_px: noise.sqrt() / self.scatter.max(1.0),
            column_px: better.at,
            columns: (self.x[better.from] as usize, self.x[better.to - 1] as usize),
        })
    }

    /// The best stretch by the points whose index has a parity.
    pub(super) fn choose(
        &self,
        range: &std::ops::Range<usize>,
        least: usize,
        parity: usize,
    ) -> Option<Choice> {
        let limits = LargestValueLimits::get();
        let points = Points { x: &self.x, y: &self.size, sd: &self.sd };
        let (n, least) = (range.len(), least.clamp(1, range.len().max(1)));
        let sums = (n > 0).then(|| RunningSums::new(points, range, parity))?;
        let ends = self.ends();
        let mut best: Option<Choice> = None;
        let stated = if WIDTHS.contains(&least) { 0 } else { least };
        for width in WIDTHS.into_iter().chain([stated]).filter(|w| (least..=n).contains(w)) {
            let lambda = limits.choice * (2.0 * (2.0 * n as f64 / width as f64).ln()).sqrt();
            let step = (width / 5).max(1);
            for from in (0..n - width).step_by(step).chain([n - width]) {
                let (from, to) = (range.start + from, range.start + from + width);
                if self.x[to - 1] - self.x[from] > width as f64 + limits.bridge_px {
                    continue;
                }
                // A narrow stretch inside the line is represented by its mean alone.
                let inside = width < limits.least_of_parabola && !(ends[from].0 || ends[to - 1].1);
                let least_score = best.map_or(f64::NEG_INFINITY, |b| b.score);
                if inside && sums.mean_bound(from, to, lambda) < least_score - ROUNDING {
                    continue;
                }
                let indices = (from + (from + parity) % 2..to).step_by(2);
                let Some(fit) = sums.fit(from, to) else { continue };
                for (order, at) in self.candidates(&fit, (from, to), least, &ends).into_iter().flatten() {
                    let beats = |score: f64| best.is_none_or(|b| score > b.score);
                    // Residuals are independent of the value: all points may test whether the fit
                    // describes them.
                    let describes = || {
                        order == Order::Mean
                            || Fit::new(&points, from..to)
                                .is_some_and(|all| all.describes(order, &points, from..to))
                    };
                    if !(beats(fit.bound(order, at, lambda)) && describes()) {
                        continue;
                    }
                    let e = fit.estimate(order, at, &points, indices.clone());
                    let score = e.value - lambda * e.u_noise.hypot(e.excess);
                    if beats(score) {
                        best = Some(Choice { from, to, order, at, score });
                    }
                }
            }
        }
        // A line in pieces has no stretch without gaps: all of it stands for itself.
        best.or_else(|| {
            let at = 0.5 * (self.x.get(range.start)? + self.x.get(range.end.checked_sub(1)?)?);
            Some(Choice {
                from: range.start,
                to: range.end,
                order: Order::Mean,
                at,
                score: f64::NEG_INFINITY,
            })
        })
    }

    /// Candidates that represent a stretch.
    fn candidates(
        &self,
        fit: &Fit,
        (from, to): (usize, usize),
        least: usize,
        ends: &[Ends],
    ) -> [Option<(Order, f64)>; 4] {
        let limits = LargestValueLimits::get();
        let width = to - from;
        let (first, last) = (self.x[from], self.x[to - 1]);
        let end = |at: f64, ends: bool| (width >= limits.least_of_line && ends).then_some((Order::Line, at));
        let vertex = if width >= limits.least_of_parabola { fit.vertex() } else { None };
        [
            (width <= limits.widest_mean.max(least)).then_some((Order::Mean, 0.5 * (first + last))),
            end(first, ends[from].0),
            end(last, ends[to - 1].1),
            vertex.map(|at| (Order::Parabola, at)),
        ]
    }

    /// Whether the line ends at each of its points.
    fn ends(&self) -> Reused<Ends> {
        (0..self.len()).map(|i| (self.ends_at(i, -1), self.ends_at(i, 1))).collect()
    }

    /// Whether the line ends at a point on the side of `step`: nothing follows, or what follows
    /// lies far below.
    fn ends_at(&self, index: usize, step: isize) -> bool {
        let limits = LargestValueLimits::get();
        let inside = |i: isize| (0..self.len() as isize).contains(&i);
        let index = index as isize;
        // Blur rounds the corner itself off: the second to fifth point beyond it are compared.
        let beyond = index + 2 * step;
        if !inside(beyond) || (self.x[beyond as usize] - self.x[index as usize]).abs() > limits.bridge_px {
            return true;
        }
        let mean = |from: isize, step: isize| {
            let taken = (0..4).map(|k| from + k * step).filter(|i| inside(*i));
            let (sum, n) = taken.fold((0.0, 0.0), |(s, n), i| (s + self.size[i as usize], n + 1.0));
            sum / n
        };
        mean(index, -step) - mean(beyond, step)
            > (limits.shoulder * self.sd[index as usize]).max(limits.shoulder_px)
    }

    /// Estimate of a stretch by the points that did not choose it.
    fn measure(&self, choice: &Choice, parity: usize) -> Option<Estimate> {
        let limits = LargestValueLimits::get();
        let points = Points { x: &self.x, y: &self.shown, sd: &self.sd };
        let (mut from, mut to) = (choice.from, choice.to);
        let length = self.x[to - 1] - self.x[from];
        let reach = match choice.order {
            Order::Mean => f64::INFINITY,
            Order::Line => limits.measured * length,
            Order::Parabola => 0.5 * limits.measured * length,
        };
        let near = |i: &usize| (self.x[*i] - choice.at).abs() <= reach;
        if (from..to).filter(near).count() >= limits.least_of_line {
            from = (from..to).find(near)?;
            to = (from..to).rfind(near)? + 1;
        }
        // Between the outermost points that chose: beyond them the stretch may have ended.
        let first = from + (from + parity) % 2 + 1;
        let last = to - 1 - (to - 1 + parity) % 2;
        let between = (first..last).step_by(2);
        let fewest = match choice.order {
            Order::Mean => 1,
            Order::Line => 3,
            Order::Parabola => 4,
        };
        let (first, last, by) = if between.len() >= fewest { (first, last, 2) } else { (from, to, 1) };
        let indices = (first..last).step_by(by);
        let fit = Fit::new(&points, indices.clone())?;
        Some(fit.estimate(choice.order, choice.at, &points, indices))
    }
}

/// Scatter of values over their stated noise, by the median of their fourth differences (Σw² = 70
/// of white noise), which slopes, steps and waves of ten columns or more hardly move.
fn scatter(values: &[f64], noise: &[f64]) -> f64 {
    let limits = LargestValueLimits::get();
    let mut sizes: Reused<f64> = values
        .windows(5)
        .zip(noise.windows(5))
        .map(|(v, s)| {
            let difference = v[0] - 4.0 * v[1] + 6.0 * v[2] - 4.0 * v[3] + v[4];
            difference.abs() / (70.0_f64.sqrt() * s[2].max(1e-12))
        })
        .collect();
    if sizes.is_empty() {
        return 1.0;
    }
    let mut quantile = |share: f64| {
        let at = (share * sizes.len() as f64) as usize;
        *sizes.select_nth_unstable_by(at, f64::total_cmp).1
    };
    // Quantiles of |z|: .6745 and .3186. Corners (a thread has them in half of its columns) raise
    // the median, noise alone hardly the ratio.
    let (half, quarter) = (quantile(0.5) / 0.6745, quantile(0.25) / 0.3186);
    let scatter = if quarter < limits.corners * half { quarter } else { half };
    scatter.max(limits.least_scatter)
}

/// Whether one value alone is an outlier of its neighbours.
fn is_speck(values: &[f64], index: usize, limit: f64) -> bool {
    if index < 2 || index + 2 >= values.len() {
        return false;
    }
    let mut five = [0.0; 5];
    five.copy_from_slice(&values[index - 2..=index + 2]);
    five.sort_by(f64::total_cmp);
    (values[index] - five[2]).abs() > limit
}

#[cfg(test)]
mod tests;
