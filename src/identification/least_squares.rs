//! Weighted least squares with a prior of every unknown.
//!
//! Unknowns are scaled by their standard deviations before any reading: x = S·z, z of mean 0. With
//! J = A·S of rows divided by their u, the estimate is z = (JᵀJ + P)⁻¹Jᵀy, its covariance
//! (JᵀJ + P)⁻¹ times the reduced χ² where that is above 1 (Birge 1932). P is 1 of every unknown, of
//! a shape (S/τ)² with τ chosen by the held-out error: the penalty of a P-spline as a prior (Wahba
//! 1983), so that the covariance holds what smoothing takes off, too.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::equations::{Equation, FOLDS, scaled};
use super::rank::Rank;
use super::unknowns::{Group, Unknowns};
use crate::machine::ErrorName;

/// Steps of the smoothing, from the class of the machine downwards, each a decade of τ: the
/// held-out error is flat about its least.
const SMOOTHINGS: usize = 6;
/// Rounds over the errors in which each one's smoothing is chosen, the others kept.
const ROUNDS: usize = 2;

/// JᵀJ and Jᵀy of the equations of one fold.
#[derive(Clone)]
struct Normal {
    square: DMatrix<f64>,
    right: DVector<f64>,
}

impl Normal {
    fn of<'a>(equations: impl Iterator<Item = &'a Equation>, unknowns: &Unknowns) -> Self {
        let count = unknowns.all.len();
        let mut normal = Self { square: DMatrix::zeros(count, count), right: DVector::zeros(count) };
        for equation in equations {
            let row = scaled(equation, unknowns);
            let y = equation.value / equation.u;
            for (i, a) in &row {
                normal.right[*i] += a * y;
                for (j, b) in &row {
                    normal.square[(*i, *j)] += a * b;
                }
            }
        }
        normal
    }

    fn solve(&self, penalty: &DVector<f64>) -> Option<(DVector<f64>, Cholesky<f64, Dyn>)> {
        let mut square = self.square.clone();
        for (k, p) in penalty.iter().enumerate() {
            square[(k, k)] += p;
        }
        let cholesky = square.cholesky()?;
        Some((cholesky.solve(&self.right), cholesky))
    }
}

/// An estimate of all unknowns.
#[derive(Clone, Debug)]
pub(crate) struct Estimate {
    /// The unknowns, mm and rad.
    pub values: Vec<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// √ of χ² by its degrees of freedom.
    pub birge_ratio: f64,
    /// Error on turned parts that took no part, about their own datum, rms, mm; none where none can
    /// be left out.
    pub held_out_mm: Option<f64>,
    /// Error at positions that took no part, of all readings by their u, rms.
    pub held_out_by_u: f64,
}

/// The estimate, each error as smooth as leaves the least held-out error.
///
/// Errors whose shapes the readings do not separate (`rank`) are as smooth as each other: left to
/// themselves, one of them would take all of it and the other be certain to be straight.
/// `left_out` are the sets of turned parts that are predicted from all others, one by one.
pub(crate) fn estimate(
    unknowns: &Unknowns,
    equations: &[Equation],
    rank: &Rank,
    left_out: &[usize],
) -> Option<Estimate> {
    let folds: Vec<Normal> =
        (0..FOLDS).map(|fold| Normal::of(equations.iter().filter(|e| e.fold == fold), unknowns)).collect();
    let whole = folds.iter().skip(1).fold(folds[0].clone(), |sum, fold| Normal {
        square: sum.square + &fold.square,
        right: sum.right + &fold.right,
    });
    let without =
        |fold: &Normal| Normal { square: &whole.square - &fold.square, right: &whole.right - &fold.right };
    let held = HeldOut { unknowns, equations, others: folds.iter().map(without).collect() };
    let smoothing = held.choose(&alike(unknowns, rank))?;
    let penalty = penalty(unknowns, &smoothing);
    let (scaled_values, cholesky) = whole.solve(&penalty)?;
    let inverse = cholesky.inverse();
    let values: Vec<f64> =
        scaled_values.iter().zip(&unknowns.all).map(|(z, unknown)| z * unknown.prior).collect();
    let effective = inverse.component_mul(&whole.square).sum();
    let freedom = (equations.len() as f64 - effective).max(1.0);
    let chi2: f64 = equations.iter().map(|e| (residual(e, &values) / e.u).powi(2)).sum();
    let birge_ratio = (chi2 / freedom).sqrt();
    let widen = birge_ratio.max(1.0).powi(2);
    let covariance = DMatrix::from_fn(values.len(), values.len(), |i, j| {
        widen * unknowns.all[i].prior * inverse[(i, j)] * unknowns.all[j].prior
    });
    Some(Estimate {
        values,
        covariance,
        birge_ratio,
        held_out_mm: parts_left_out(unknowns, equations, &penalty, left_out),
        held_out_by_u: held.error_by_u(&smoothing)?,
    })
}

/// Value of a reading less what the unknowns give.
pub(crate) fn residual(equation: &Equation, values: &[f64]) -> f64 {
    equation.value - equation.factors.iter().map(|(k, factor)| factor * values[*k]).sum::<f64>()
}

/// Steps of the smoothing of each error, in the order of `Unknowns::errors`.
type Smoothing = Vec<usize>;

/// Indices of the errors that have a shape, those together that are as smooth as each other.
fn alike(unknowns: &Unknowns, rank: &Rank) -> Vec<Vec<usize>> {
    let place = |name: ErrorName| unknowns.errors.iter().position(|sought| sought.error == name);
    let mut alike: Vec<Vec<usize>> = Vec::new();
    for found in &rank.together {
        let shapes = found.groups.iter().filter_map(|group| match group {
            Group::Shape(name) => place(*name),
            _ => None,
        });
        let members: Vec<usize> = shapes.collect();
        if !members.is_empty() {
            alike.push(members);
        }
    }
    let with_shape = (0..unknowns.errors.len()).filter(|k| unknowns.errors[*k].basis.is_some());
    let alone: Vec<Vec<usize>> =
        with_shape.filter(|k| !alike.iter().flatten().any(|taken| taken == k)).map(|k| vec![k]).collect();
    alike.extend(alone);
    alike
}

fn penalty(unknowns: &Unknowns, smoothing: &[usize]) -> DVector<f64> {
    let of = |group: &Group| match group {
        Group::Shape(name) => 10.0_f64.powi(2 * step_of(unknowns, smoothing, *name) as i32),
        _ => 1.0,
    };
    DVector::from_iterator(unknowns.all.len(), unknowns.all.iter().map(|unknown| of(&unknown.group)))
}

fn step_of(unknowns: &Unknowns, smoothing: &[usize], name: ErrorName) -> usize {
    let place = unknowns.errors.iter().position(|sought| sought.error == name);
    place.and_then(|k| smoothing.get(k)).copied().unwrap_or(0)
}

/// The rms of parts that are left out one by one, about their own datum, mm.
fn parts_left_out(
    unknowns: &Unknowns,
    equations: &[Equation],
    penalty: &DVector<f64>,
    left_out: &[usize],
) -> Option<f64> {
    let (mut squares, mut count) = (0.0, 0_usize);
    for set in left_out {
        let normal = Normal::of(equations.iter().filter(|e| e.set != *set), unknowns);
        let (scaled, _) = normal.solve(penalty)?;
        let values: Vec<f64> = scaled.iter().zip(&unknowns.all).map(|(z, u)| z * u.prior).collect();
        let own: Vec<&Equation> = equations.iter().filter(|e| e.set == *set).collect();
        let datum: Vec<usize> =
            (0..unknowns.all.len()).filter(|k| unknowns.all[*k].group == Group::Datum(*set)).collect();
        let factor = |equation: &Equation, k: usize| -> f64 {
            equation.factors.iter().filter(|(at, _)| *at == k).map(|(_, factor)| factor).sum()
        };
        let columns = DMatrix::from_fn(own.len(), datum.len(), |i, j| factor(own[i], datum[j]));
        let off = DVector::from_iterator(own.len(), own.iter().map(|e| residual(e, &values)));
        let fitted = columns.clone().svd(true, true).solve(&off, 1e-12).ok()?;
        squares += (off - columns * fitted).norm_squared();
        count += own.len();
    }
    (count > 0).then(|| (squares / count as f64).sqrt())
}

struct HeldOut<'a> {
    unknowns: &'a Unknowns,
    equations: &'a [Equation],
    /// The whole without each fold.
    others: Vec<Normal>,
}

impl HeldOut<'_> {
    /// The smoothing with the least error, error by error.
    fn choose(&self, alike: &[Vec<usize>]) -> Option<Smoothing> {
        let mut smoothing = vec![SMOOTHINGS / 2; self.unknowns.errors.len()];
        for _ in 0..ROUNDS {
            let before = smoothing.clone();
            for members in alike {
                let mut best = (f64::INFINITY, smoothing[members[0]]);
                for step in 0..SMOOTHINGS {
                    members.iter().for_each(|k| smoothing[*k] = step);
                    let by_u = self.error_by_u(&smoothing)?;
                    if by_u < best.0 {
                        best = (by_u, step);
                    }
                }
                members.iter().for_each(|k| smoothing[*k] = best.1);
            }
            if smoothing == before {
                break;
            }
        }
        Some(smoothing)
    }

    fn error_by_u(&self, smoothing: &[usize]) -> Option<f64> {
        let penalty = penalty(self.unknowns, smoothing);
        let mut by_u = 0.0;
        for (k, others) in self.others.iter().enumerate() {
            let (values, _) = others.solve(&penalty)?;
            let values: Vec<f64> =
                values.iter().zip(&self.unknowns.all).map(|(z, unknown)| z * unknown.prior).collect();
            let own = self.equations.iter().filter(|e| e.fold == k);
            by_u += own.map(|e| (residual(e, &values) / e.u).powi(2)).sum::<f64>();
        }
        Some((by_u / self.equations.len().max(1) as f64).sqrt())
    }
}
