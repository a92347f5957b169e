//! Tolerances and the one rule by which the whole program judges conformity to them.
//!
//! [`Tolerance`] is the statement of a drawing: limits of size (ISO 286-1) and the size that they
//! apply to (ISO 14405-1). `DecisionRule` is ISO 14253-1:2017 with the probability of conformity
//! of JCGM 106:2012: both limits at once, Student's t at the effective degrees of freedom.
//! `Judge` gives the five classes of a comparator by that rule.
//!
//! In: a text or a table of a drawing, a reading with u and its degrees of freedom. Out: limits, a
//! decision with its probability, the verdict on a part (`part_verdict`) from the readings of its
//! stations. All lengths are in mm. `drawing` parses texts with the tables of `iso_286` and the
//! modifiers of `criterion`. A new notation for tolerances is a case there, a new rule a method of
//! `DecisionRule`.

mod criterion;
mod decision;
mod drawing;
mod error;
mod iso_286;
mod judgement;
pub(crate) mod part_verdict;
mod tolerance;

pub use self::{
    criterion::SizeCriterion,
    error::{JudgementError, ToleranceError},
    judgement::{Judgement, Limits},
    tolerance::Tolerance,
};
pub(crate) use decision::{Decision, DecisionRule, Estimate, MANY, PROBABILITY};
pub(crate) use judgement::Judge;
