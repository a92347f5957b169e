//! The input of a law from a pass, and its proposal for the next one.

use crate::control::context::NextPass;
use crate::control::fit::{self, Fit};
use crate::control::readings::Errors;
use crate::plan::PassPlan;
use nalgebra::{DMatrix, DVector};

/// The input of a law: the measured pass.
pub(crate) struct Observation<'a> {
    /// The command, with the offsets in force.
    pub plan: &'a PassPlan,
    /// Errors of the pass.
    pub errors: &'a Errors,
    /// The next pass, where it is given.
    pub next: Option<NextPass>,
}

impl Observation<'_> {
    /// Offsets in force, mm of diameter.
    pub(super) fn in_force(&self) -> &[f64] {
        &self.plan.offset.o_mm
    }
}

/// Offsets proposed by a law.
pub(crate) struct Proposal {
    /// Offsets of the next pass, mm of diameter.
    pub o_mm: Vec<f64>,
    /// Remarks for the log.
    pub notes: Vec<String>,
    /// Why the offsets in force shall hold instead.
    pub hold: Option<String>,
}

impl Proposal {
    /// Offsets and remarks.
    pub(super) fn with_notes(o_mm: Vec<f64>, notes: Vec<String>) -> Self {
        Self { o_mm, notes, hold: None }
    }

    /// The offsets in force, held for a reason.
    pub(crate) fn hold(seen: &Observation<'_>, reason: String) -> Self {
        Self { o_mm: seen.in_force().to_vec(), notes: Vec::new(), hold: Some(reason) }
    }
}

impl From<Vec<f64>> for Proposal {
    fn from(o_mm: Vec<f64>) -> Self {
        Self::with_notes(o_mm, Vec::new())
    }
}

/// How offsets from earlier parts are combined with the proposal of a law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Feedforward {
    /// The proposal starts from the offsets in force: the difference of the next pass's to this
    /// pass's is added.
    Difference,
    /// The proposal starts from zero: the next pass's is added.
    Whole,
    /// The proposal already predicts the next pass: nothing is added.
    Nothing,
}

/// A control law. It proposes; the compensator decides whether the proposal and the new state of
/// the law are kept.
pub(crate) trait Law: Clone {
    /// A new part: discards the state of the last one. `stock_mm` are its diameters before the
    /// first pass, where measured.
    fn begin(&mut self, stock_mm: Option<Vec<f64>>);

    /// Offsets of the next pass.
    fn propose(&mut self, seen: &Observation<'_>) -> Proposal;

    /// How offsets from earlier parts are added.
    fn feedforward(&self) -> Feedforward {
        Feedforward::Difference
    }
}

pub(super) fn y(errors: &Errors) -> DVector<f64> {
    DVector::from_vec(errors.e_mm())
}

/// Standard uncertainty that is independent from station to station; the combined one where it is
/// not stated.
pub(super) fn independent_u(errors: &Errors) -> DVector<f64> {
    let stated = errors.stations.iter().all(|s| s.u_random_mm > 0.0);
    let u = errors.stations.iter().map(|s| if stated { s.u_random_mm } else { s.u_mm });
    DVector::from_vec(u.collect())
}

/// Fits shapes to the errors, weighted by the uncertainties that are independent from station to
/// station.
pub(super) fn project(design: &DMatrix<f64>, errors: &Errors) -> Option<Fit> {
    fit::weighted(design, &y(errors), &independent_u(errors))
}
