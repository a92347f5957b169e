//! Errors of tolerances and judgements.

use thiserror::Error;

/// Why a text is not judged as a tolerance.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ToleranceError {
    /// It is not a tolerance.
    #[error(
        "{text:?} is no tolerance: {why}; right would be \"25 h6\", \"25 ±0.01\", \"25 0/-0.013\" or \"24.987..25\""
    )]
    Wrong {
        /// The text.
        text: String,
        /// What is wrong.
        why: String,
    },
    /// It is a tolerance that silhouettes of a shaft cannot verify.
    #[error("{text:?} cannot be judged: {why}")]
    Unjudged {
        /// The text.
        text: String,
        /// Why.
        why: String,
    },
}

/// Why limits cannot judge.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum JudgementError {
    /// Limits not in ascending order.
    #[error("the limits {limits_mm:?} mm are not finite and in ascending order")]
    Order {
        /// The limits, lowest first.
        limits_mm: Vec<f64>,
    },
    /// A probability of conformity out of range.
    #[error("conformance probability {value}: must be at least 0.5 and below 1 (ISO 14253-1: 0.95)")]
    Probability {
        /// The value given.
        value: f64,
    },
    /// The uncertainty leaves no acceptance zone.
    #[error(
        "an uncertainty of u = {u_mm} mm leaves no acceptance zone in a tolerance of {tolerance_mm} mm: to prove conformity to both \
         limits it takes {least_mm} mm"
    )]
    NoAcceptanceZone {
        /// Combined standard uncertainty, mm.
        u_mm: f64,
        /// Width of the zone, mm.
        tolerance_mm: f64,
        /// Least width that accepts anything, mm.
        least_mm: f64,
    },
}
