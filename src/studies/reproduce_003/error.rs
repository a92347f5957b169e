//! Errors of a reproduction.

use thiserror::Error;

use crate::closed_loop::LoopError;
use crate::process::ProcessError;
use crate::process::fit::FitError;
use crate::studies::factor::FactorError;

/// Why a reproduction cannot be computed from the inputs.
#[derive(Debug, Error)]
#[non_exhaustive]
pub(crate) enum ReproductionError {
    /// An input out of range.
    #[error("{key}: {problem}")]
    Input {
        /// Dotted key.
        key: String,
        /// What is wrong, and the valid values.
        problem: String,
    },
    /// The forces.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The single-factor studies.
    #[error(transparent)]
    Factor(#[from] FactorError),
    /// The choice of cutting data.
    #[error(transparent)]
    Optimize(#[from] crate::setting::SettingError),
    /// The turning process.
    #[error(transparent)]
    Process(#[from] ProcessError),
    /// The loop through frames.
    #[error(transparent)]
    Loop(#[from] LoopError),
    /// The job that the physical plant is based on.
    #[error("the built-in job: {0}")]
    Job(String),
}
