//! How smooth each error is: by the probability of the readings, averaged over what is likely.
//!
//! The shape of an error has the prior spread τ for each of its unknowns (the penalty of a
//! P-spline, Wahba 1983). With unknowns z in units of their prior and P = 1, of a shape (S/τ)², the
//! readings y (by their u) have the log probability
//!
//! ```text
//! ln p(y | τ) = ½·(ln det P − ln det(JᵀJ + P) + yᵀJ·z) + const,   z = (JᵀJ + P)⁻¹Jᵀy
//! ```
//!
//! (MacKay 1992). One τ alone, taken as known, leaves out that it is not: with the one of the least
//! held-out error intervals of 95 % held 87 % of the truth. Values and covariance are therefore
//! means over the τ of every error in turn, the others at their most probable, with the scatter of
//! the values added. A change along one τ is taken as additive to those along others.

use nalgebra::{DMatrix, DVector};

use super::normal_equations::Normal;
use super::rank::Rank;
use super::unknowns::{Group, Unknowns};
use crate::machine::ErrorName;

/// Steps of τ from the class of the machine downwards, each half a decade: the probability changes
/// by less than its own width over one. The last bends a slide by about a thirtieth of the class.
/// Steps below it, at which readings show no shape at all, would count all the more the more of
/// them there are: with five more, 87 % of a straightness (drawn between a third and a hundredth of
/// the class, noise a fiftieth) lie within 2u, with these 95 %, with one less 96 %. So does
/// `study machine-coverage`: 95.5 % of the figures of 4000 machines (seeds 1 and 77).
const STEPS: usize = 6;
/// Rounds over the errors in which each one's τ is chosen, the others kept.
const ROUNDS: usize = 3;
/// Share of the most probable τ's weight below which another one changes nothing that is stated.
const LEAST_WEIGHT: f64 = 1e-3;

/// Steps of the smoothing of each error, in the order of `Unknowns::errors`.
pub(super) type Smoothing = Vec<usize>;

/// Scaled unknowns with their covariance.
pub(super) struct Averaged {
    /// z.
    pub values: DVector<f64>,
    /// Covariance of z.
    pub covariance: DMatrix<f64>,
}

/// Indices of the errors that have a shape, those together that are as smooth as each other: errors
/// whose shapes the readings do not separate (`rank`). Left to themselves, one of them would take
/// all of it and the other be certain to be straight.
pub(super) fn alike(unknowns: &Unknowns, rank: &Rank) -> Vec<Vec<usize>> {
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

/// P: 1 of every unknown, of a shape (S/τ)².
pub(super) fn penalty(unknowns: &Unknowns, smoothing: &[usize]) -> DVector<f64> {
    let step_of = |name: ErrorName| {
        let place = unknowns.errors.iter().position(|sought| sought.error == name);
        place.and_then(|k| smoothing.get(k)).copied().unwrap_or(0)
    };
    let of = |group: &Group| match group {
        Group::Shape(name) => 10.0_f64.powi(step_of(*name) as i32),
        _ => 1.0,
    };
    DVector::from_iterator(unknowns.all.len(), unknowns.all.iter().map(|unknown| of(&unknown.group)))
}

/// ln p(y | τ) but for a constant, with the values and their covariance.
struct At {
    log_probability: f64,
    values: DVector<f64>,
    /// Inverse of JᵀJ + P where it was asked for.
    covariance: Option<DMatrix<f64>>,
}

fn at(normal: &Normal, unknowns: &Unknowns, smoothing: &[usize], with_covariance: bool) -> Option<At> {
    let penalty = penalty(unknowns, smoothing);
    let (values, cholesky) = normal.solve(&penalty)?;
    let of_prior: f64 = penalty.iter().map(|p| p.ln()).sum();
    let of_both: f64 = cholesky.l_dirty().diagonal().iter().map(|l| 2.0 * l.ln()).sum();
    let log_probability = 0.5 * (of_prior - of_both + normal.right.dot(&values));
    let covariance = with_covariance.then(|| cholesky.inverse());
    Some(At { log_probability, values, covariance })
}

/// The most probable smoothing, error by error.
pub(super) fn most_probable(normal: &Normal, unknowns: &Unknowns, alike: &[Vec<usize>]) -> Option<Smoothing> {
    let mut smoothing = vec![STEPS / 2; unknowns.errors.len()];
    for _ in 0..ROUNDS {
        let before = smoothing.clone();
        for members in alike {
            let mut best = (f64::NEG_INFINITY, smoothing[members[0]]);
            for step in 0..STEPS {
                members.iter().for_each(|k| smoothing[*k] = step);
                let found = at(normal, unknowns, &smoothing, false)?.log_probability;
                if found > best.0 {
                    best = (found, step);
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

/// Values and covariance, averaged over the smoothing of every error about the most probable one.
pub(super) fn averaged(
    normal: &Normal,
    unknowns: &Unknowns,
    alike: &[Vec<usize>],
    most_probable: &[usize],
) -> Option<Averaged> {
    let middle = at(normal, unknowns, most_probable, true)?;
    let own = middle.covariance?;
    let (mut values, mut covariance) = (middle.values.clone(), own.clone());
    for members in alike {
        let (mut sum, mut mean) = (0.0, DVector::zeros(values.len()));
        let (mut inner, mut squares) =
            (DMatrix::zeros(own.nrows(), own.ncols()), DMatrix::zeros(own.nrows(), own.ncols()));
        for step in 0..STEPS {
            let mut smoothing = most_probable.to_vec();
            members.iter().for_each(|k| smoothing[*k] = step);
            let log = at(normal, unknowns, &smoothing, false)?.log_probability;
            let weight = (log - middle.log_probability).exp();
            if !(weight > LEAST_WEIGHT) {
                continue;
            }
            let found = at(normal, unknowns, &smoothing, true)?;
            let off = &found.values - &middle.values;
            sum += weight;
            squares += weight * &off * off.transpose();
            mean += weight * off;
            inner += weight * (found.covariance? - &own);
        }
        mean /= sum;
        covariance += inner / sum + squares / sum - &mean * mean.transpose();
        values += mean;
    }
    Some(Averaged { values, covariance })
}
