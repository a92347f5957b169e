//! Tolerances and the one rule by which the whole program judges conformity to them.
//!
//! [`Tolerance`] is what a drawing states: limits of size (ISO 286-1) and what size is meant (ISO 14405-1). [`DecisionRule`] is ISO
//! 14253-1:2017 with the probability of conformity of JCGM 106:2012: both limits at once, Student's t at the effective degrees of
//! freedom. [`Judge`] gives the five classes of a comparator by that rule.

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
pub use error::JudgementError;
pub use error::ToleranceError;
pub use judgement::{Judge, Judgement, Limits};
pub use tolerance::Tolerance;
