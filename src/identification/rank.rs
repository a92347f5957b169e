//! What the readings alone determine, and which unknowns they do not separate.
//!
//! The singular values of the rows by their u, of unknowns in units of their standard deviation
//! before any reading, are ratios: below 1 the readings contain less of a combination than the
//! class of the machine does without them. The projector on these combinations shows which groups
//! of unknowns take part (its blocks on the diagonal) and which stand in for each other (those
//! beside it); its blocks do not depend on the basis that the decomposition happens to choose.

use nalgebra::DMatrix;

use super::equations::{Equation, scaled};
use super::unknowns::{Group, Unknowns};

/// Least trace of a group's block with which it takes part: a hundredth of one combination.
const TAKES_PART: f64 = 0.01;
/// Least Frobenius norm of a block between two groups that stand in for each other. A combination
/// of one part in a hundred of the lesser group has a norm of a tenth.
const STANDS_IN: f64 = 0.02;
/// Singular values below this share of the largest are rounding.
const ROUNDING: f64 = 1e-11;

/// Rank of the readings.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Rank {
    /// Number of unknowns.
    pub unknowns: usize,
    /// Number of combinations of which the readings hold anything at all.
    pub rank: usize,
    /// Number of combinations of which they hold more than the class of the machine.
    pub determined: usize,
    /// Groups that cannot be separated from each other, or alone are not determined.
    pub together: Vec<Inseparable>,
}

/// Groups of unknowns that the readings do not separate.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Inseparable {
    /// The groups.
    pub groups: Vec<Group>,
    /// Number of combinations.
    pub dimension: f64,
}

/// The rank of equations.
pub(crate) fn rank(unknowns: &Unknowns, equations: &[Equation]) -> Rank {
    let count = unknowns.all.len();
    let mut rows = DMatrix::zeros(equations.len().max(count), count);
    for (i, equation) in equations.iter().enumerate() {
        for (k, factor) in scaled(equation, unknowns) {
            rows[(i, k)] += factor;
        }
    }
    let triangle = rows.qr().unpack_r();
    let decomposed = triangle.svd(false, true);
    let values = decomposed.singular_values;
    let largest = values.iter().copied().fold(0.0, f64::max);
    let rank = values.iter().filter(|v| **v > ROUNDING * largest).count();
    let determined = values.iter().filter(|v| **v > 1.0).count();
    let mut projector = DMatrix::zeros(count, count);
    if let Some(right) = decomposed.v_t {
        for (k, _) in values.iter().enumerate().filter(|(_, value)| **value <= 1.0) {
            let row = right.row(k);
            projector += row.transpose() * row;
        }
    }
    Rank { unknowns: count, rank, determined, together: components(unknowns, &projector) }
}

/// The groups of which the projector holds anything, those together that stand in for each other.
fn components(unknowns: &Unknowns, projector: &DMatrix<f64>) -> Vec<Inseparable> {
    let mut groups: Vec<(Group, Vec<usize>)> = Vec::new();
    for (k, unknown) in unknowns.all.iter().enumerate() {
        match groups.iter_mut().find(|(group, _)| *group == unknown.group) {
            Some((_, members)) => members.push(k),
            None => groups.push((unknown.group.clone(), vec![k])),
        }
    }
    let block = |a: &[usize], b: &[usize]| -> f64 {
        let squares = a.iter().flat_map(|i| b.iter().map(|j| projector[(*i, *j)].powi(2)));
        squares.sum::<f64>().sqrt()
    };
    let trace = |a: &[usize]| a.iter().map(|i| projector[(*i, *i)]).sum::<f64>();
    let mut left: Vec<(Group, Vec<usize>)> =
        groups.into_iter().filter(|(_, members)| trace(members) > TAKES_PART).collect();
    let mut found = Vec::new();
    while let Some(first) = left.pop() {
        let mut together = vec![first];
        let mut at = 0;
        while at < together.len() {
            let own = together[at].1.clone();
            let (linked, rest) = left.into_iter().partition(|(_, members)| block(&own, members) > STANDS_IN);
            left = rest;
            together.extend::<Vec<_>>(linked);
            at += 1;
        }
        let dimension = together.iter().map(|(_, members)| trace(members)).sum();
        together.sort_by_key(|(_, members)| members[0]);
        found.push(Inseparable { groups: together.into_iter().map(|(group, _)| group).collect(), dimension });
    }
    found.reverse();
    found
}
