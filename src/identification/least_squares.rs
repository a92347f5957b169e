//! Weighted least squares with a prior of every unknown.
//!
//! Unknowns are scaled by their standard deviations before any reading: x = S·z, z of mean 0. With
//! J = A·S of rows divided by their u, the estimate is z = (JᵀJ + P)⁻¹Jᵀy, its covariance
//! (JᵀJ + P)⁻¹; P states how smooth an error is ([`super::smoothing`]), and the covariance holds
//! what smoothing takes off, too. Where the reduced χ² is larger than that of 95 % of readings
//! whose u is true, the covariance is widened by it (Birge 1932): widened wherever it is above 1,
//! as it is by chance in half of all cases, intervals of 95 % would hold 97 %.

use nalgebra::{DMatrix, DVector};

use super::equations::{Equation, FOLDS};
use super::normal_equations::Normal;
use super::rank::Rank;
use super::smoothing::{alike, averaged, most_probable, penalty};
use super::unknowns::{Group, Unknowns};
use crate::numerics::distributions::chi2_ratio_limit;

/// Normal quantile of 95 %.
const Z_95: f64 = 1.645;

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

/// The estimate, averaged over how smooth each error may be. `left_out` are the sets of turned
/// parts that are predicted from all others, one by one.
pub(crate) fn estimate(
    unknowns: &Unknowns,
    equations: &[Equation],
    rank: &Rank,
    left_out: &[usize],
) -> Option<Estimate> {
    let whole = Normal::of(equations.iter(), unknowns);
    let alike = alike(unknowns, rank);
    let smoothing = most_probable(&whole, unknowns, &alike)?;
    let penalty = penalty(unknowns, &smoothing);
    let effective = whole.solve(&penalty)?.1.inverse().component_mul(&whole.square).sum();
    let found = averaged(&whole, unknowns, &alike, &smoothing)?;
    let values: Vec<f64> =
        found.values.iter().zip(&unknowns.all).map(|(z, unknown)| z * unknown.prior).collect();
    let freedom = (equations.len() as f64 - effective).max(1.0);
    let chi2: f64 = equations.iter().map(|e| (residual(e, &values) / e.u).powi(2)).sum();
    let reduced = chi2 / freedom;
    let widen = if reduced > chi2_ratio_limit(freedom, Z_95) { reduced } else { 1.0 };
    let covariance = DMatrix::from_fn(values.len(), values.len(), |i, j| {
        widen * unknowns.all[i].prior * found.covariance[(i, j)] * unknowns.all[j].prior
    });
    Some(Estimate {
        values,
        covariance,
        birge_ratio: reduced.sqrt(),
        held_out_mm: parts_left_out(unknowns, equations, &penalty, left_out),
        held_out_by_u: held_out_by_u(unknowns, equations, &whole, &penalty)?,
    })
}

/// Value of a reading less what the unknowns give.
pub(crate) fn residual(equation: &Equation, values: &[f64]) -> f64 {
    equation.value - equation.factors.iter().map(|(k, factor)| factor * values[*k]).sum::<f64>()
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

/// Error at positions that take no part, fold by fold, of all readings by their u, rms.
fn held_out_by_u(
    unknowns: &Unknowns,
    equations: &[Equation],
    whole: &Normal,
    penalty: &DVector<f64>,
) -> Option<f64> {
    let mut by_u = 0.0;
    for fold in 0..FOLDS {
        let own = || equations.iter().filter(move |e| e.fold == fold);
        let out = Normal::of(own(), unknowns);
        let others = Normal { square: &whole.square - out.square, right: &whole.right - out.right };
        let (values, _) = others.solve(penalty)?;
        let values: Vec<f64> =
            values.iter().zip(&unknowns.all).map(|(z, unknown)| z * unknown.prior).collect();
        by_u += own().map(|e| (residual(e, &values) / e.u).powi(2)).sum::<f64>();
    }
    Some((by_u / equations.len().max(1) as f64).sqrt())
}
