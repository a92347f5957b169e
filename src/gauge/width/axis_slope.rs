//! The slope of the axis in the image plane at every column of a frame.
//!
//! A straight part has one slope over the field, a bent one slopes otherwise at each end: D·τ²/2 at
//! half a millimetre of sag over 150 mm is half a micrometre at Ø 8, and changes by as much over a
//! field. The middles between both edges are taken for a polynomial of the fifth degree where it
//! describes them to their own roughness, and for a line otherwise.

use nalgebra::SVector;

use super::axis_pose::Pose;
use crate::gauge::edges::FrameEdges;
use crate::gauge::limit::limits;
use crate::gauge::width::reused::Reused;
use crate::numerics::normal_equations::NormalEquations;

limits! {
    /// When an axis is bent rather than straight.
    AxisSlopeLimits = "axis_slope";
    /// Fewest columns of a bent axis: sixteen blocks, ten more than coefficients.
    least_columns: usize = 256;
    /// Columns whose middles are averaged first: their noise falls to a quarter, and a bend is
    /// longer.
    block_columns: usize = 16;
    /// Residual over that of a line, below which an axis is bent: a bend below the noise changes no
    /// diameter. Tuned: see study limits.
    better: f64 = 0.7;
    /// Residual up to which the polynomial describes the middles, in units of their own roughness:
    /// steps out of the centre are no bend. Tuned: see study limits.
    rough: f64 = 2.0;
    /// What is added to that, px: the tilt that is left is 0.02 px over some hundred columns, whose
    /// cosine is 1 to 10⁻⁷.
    rough_px: f64 = 0.02;
    /// Standard deviations beyond which a middle is left out: 0.3 % of good ones are.
    far: f64 = 3.0;
    /// Rounds of that: the second has the scatter without the outliers, the third is fitted by it.
    rounds: usize = 3;
}

/// Coefficients: over a third of a half wave the slope of the best polynomial is right to 1e-6 of
/// it, that of a cubic to 1 %.
const TERMS: usize = 6;

/// Slopes of axis and flanks in a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisSlope {
    /// The straight part's.
    pose: Pose,
    bent: Option<Bent>,
}

/// A polynomial through the middles: coefficients over t = (column − middle)/half.
#[derive(Clone, Copy, Debug)]
struct Bent {
    coefficients: SVector<f64, TERMS>,
    middle: f64,
    half: f64,
}

impl AxisSlope {
    /// From the middles of the columns with both edges.
    pub(crate) fn of(edges: &FrameEdges) -> Self {
        Self { pose: Pose::of(edges), bent: Bent::through(&middles(edges)) }
    }

    /// D/w at a column.
    pub(crate) fn factor(&self, column: usize) -> f64 {
        let Some(bent) = &self.bent else { return self.pose.chord_factor() };
        Pose { tan_tilt: bent.slope(column as f64), ..self.pose }.chord_factor()
    }
}

/// Middles of blocks of columns that have both edges.
fn middles(edges: &FrameEdges) -> Reused<(f64, f64)> {
    let limits = AxisSlopeLimits::get();
    let both = edges.top.iter().zip(&edges.bottom).enumerate();
    let all: Reused<(f64, f64)> = both
        .filter(|(_, (t, b))| t.is_usable() && b.is_usable())
        .map(|(c, (t, b))| (c as f64, 0.5 * (t.row_px + b.row_px)))
        .collect();
    let mean = |block: &[(f64, f64)]| {
        let n = block.len() as f64;
        let sum = block.iter().fold((0.0, 0.0), |sum, p| (sum.0 + p.0, sum.1 + p.1));
        (sum.0 / n, sum.1 / n)
    };
    all.chunks(limits.block_columns).map(mean).collect()
}

impl Bent {
    fn through(points: &[(f64, f64)]) -> Option<Self> {
        let limits = AxisSlopeLimits::get();
        let (first, last) = (points.first()?.0, points.last()?.0);
        if points.len() < limits.least_columns / limits.block_columns {
            return None;
        }
        let (middle, half) = (0.5 * (first + last), 0.5 * (last - first));
        let line = fitted(points, (middle, half), 2)?;
        let bent = fitted(points, (middle, half), TERMS)?;
        // Second differences leave the slope out; the median of their size is √6·0.6745 of one's
        // standard deviation.
        let mut bends: Reused<f64> =
            points.windows(3).map(|p| (p[2].1 - 2.0 * p[1].1 + p[0].1).abs()).collect();
        let at = bends.len() / 2;
        let rough = *bends.select_nth_unstable_by(at, f64::total_cmp).1 / 1.652;
        let describes = bent.1 < limits.rough * rough + limits.rough_px;
        (describes && bent.1 < limits.better * line.1).then_some(Self { coefficients: bent.0, middle, half })
    }

    /// Rows per column.
    fn slope(&self, column: f64) -> f64 {
        let t = (column - self.middle) / self.half;
        let horner = |sum: f64, k: usize| sum * t + k as f64 * self.coefficients[k];
        (1..TERMS).rev().fold(0.0, horner) / self.half
    }
}

/// Least squares of the first `terms` powers without outliers; and the residual of the rest, rms.
fn fitted(
    points: &[(f64, f64)],
    (middle, half): (f64, f64),
    terms: usize,
) -> Option<(SVector<f64, TERMS>, f64)> {
    let limits = AxisSlopeLimits::get();
    let start = points[0].1;
    let basis = |x: f64| {
        let t = (x - middle) / half;
        SVector::<f64, TERMS>::from_fn(|k, _| t.powi(k as i32))
    };
    let (mut found, mut rest, mut limit) = (SVector::<f64, TERMS>::zeros(), f64::INFINITY, f64::INFINITY);
    for _ in 0..limits.rounds {
        let (mut fit, mut count) = (NormalEquations::<TERMS>::new(), 0.0);
        for (x, y) in points {
            let phi = basis(*x);
            if (y - start - found.dot(&phi)).abs() <= limit {
                fit.add(phi, y - start, 1.0);
                count += 1.0;
            }
        }
        for k in terms..TERMS {
            fit.normal.row_mut(k).fill(0.0);
            fit.normal.column_mut(k).fill(0.0);
            fit.normal[(k, k)] = 1.0;
            fit.right[k] = 0.0;
        }
        if count < (limits.least_columns / limits.block_columns / 2) as f64 {
            break;
        }
        found = fit.by_inverse()?;
        let square: f64 = points
            .iter()
            .map(|(x, y)| y - start - found.dot(&basis(*x)))
            .filter(|r| r.abs() <= limit)
            .map(|r| r * r)
            .sum();
        rest = (square / count).sqrt();
        limit = limits.far * rest + 1e-9;
    }
    Some((found, rest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauge::edges::{Edge, EdgeState};

    fn frame(middle: impl Fn(f64) -> f64, width: impl Fn(f64) -> f64) -> FrameEdges {
        let edge =
            |row_px| Edge { row_px, u_own_px: 0.01, u_shared_px: 0.0, chi2: 1.0, state: EdgeState::Good };
        let noise = |c: usize| 0.01 * ((c * 7919 % 101) as f64 / 50.0 - 1.0);
        let row = |c: usize, side: f64| edge(middle(c as f64) + noise(c) + side * 0.5 * width(c as f64));
        let (top, bottom) = (0..1200).map(|c| (row(c, -1.0), row(c, 1.0))).unzip();
        FrameEdges { top, bottom, ..FrameEdges::default() }
    }

    #[test]
    fn a_bent_axis_has_its_own_slope_at_every_column() {
        let bent = |c: f64| 400.0 + 8.0 * (c / 1200.0 * 1.2).sin();
        let slope = AxisSlope::of(&frame(bent, |_| 600.0));
        for column in [0, 300, 600, 1199] {
            let tan = 8.0 * 1.2 / 1200.0 * (column as f64 / 1200.0 * 1.2).cos();
            let expected = 1.0 / (1.0 + tan * tan).sqrt();
            let found = slope.factor(column);
            // 3e-7 of Ø 25 are 8 nm.
            assert!((found - expected).abs() < 3e-7, "{column}: {found} {expected}");
        }
    }

    #[test]
    fn a_straight_tilted_taper_and_a_crank_keep_one_slope() {
        let straight = frame(|c| 400.0 + 0.01 * c, |c| 600.0 + 0.002 * c);
        let crank = frame(|c| if c < 500.0 { 400.0 } else { 406.0 }, |_| 600.0);
        for frame in [straight, crank] {
            let slope = AxisSlope::of(&frame);
            assert!(slope.bent.is_none());
            assert_eq!(slope.factor(7).to_bits(), Pose::of(&frame).chord_factor().to_bits());
        }
    }
}
