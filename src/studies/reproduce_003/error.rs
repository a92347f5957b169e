//! Why a reproduction cannot be made from the inputs given.

use thiserror::Error;

use crate::closed_loop::LoopError;
use crate::process::ProcessError;
use crate::process::fit::FitError;
use crate::studies::factor::FactorError;

/// A reproduction that cannot be made from the inputs given.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReproductionError {
    /// An input out of range.
    #[error("{key}: {problem}")]
    Input {
        /// Dotted key.
        key: String,
        /// What is wrong and what would be right.
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
    /// The job that the physical plant stands on.
    #[error("the built-in job: {0}")]
    Job(String),
}
