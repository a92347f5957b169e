//! Tolerances and the one rule by which the whole program judges conformity to them.
//!
//! [`Tolerance`] is what a drawing states: limits of size (ISO 286-1) and what size is meant (ISO
//! 14405-1). [`DecisionRule`] is ISO 14253-1:2017 with the probability of conformity of JCGM
//! 106:2012: both limits at once, Student's t at the effective degrees of freedom. [`Judge`] gives
//! the five classes of a comparator by that rule.
//!
//! In: a text or a table of a drawing, a reading with u and its degrees of freedom. Out: limits, a
//! decision with its probability, the verdict on a part ([`part_verdict`]) from the readings of its
//! stations. All lengths are in mm. `drawing` reads texts by the tables of `iso_286` and the
//! modifiers of `criterion`; one more way to state a tolerance is one more case there, one more
//! rule one more method of [`DecisionRule`].

mod criterion;
mod decision;
mod drawing;
mod error;
mod iso_286;
mod judgement;
pub mod part_verdict;
mod tolerance;

pub use criterion::SizeCriterion;
pub use decision::{Decision, DecisionRule, Estimate, MANY, PROBABILITY};
pub use error::{JudgementError, ToleranceError};
pub use judgement::{Judge, Judgement, Limits};
pub use tolerance::Tolerance;
