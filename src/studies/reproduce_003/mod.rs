//! Reproduction of the slender-shaft paper (Xue, Miao, Xue 2023): every figure of it beside ours.
//!
//! `ours` is computed when asked, from [`Inputs`]: a changed input changes it. A row whose printed value contradicts
//! another of the paper's values says so and says which.

mod control;
mod deflection;
mod frames;
mod inputs;
mod optimum;
mod physical;

use thiserror::Error;

pub use frames::FrameRun;
pub use inputs::{Beam, Figure, Figures, Force, Handbook, Inputs, OptimumInput, PidInput};

use super::factor::FactorError;
use super::optimize::{OptimizeConfig, OptimizeError};
use super::reproduction::Row;
use crate::closed_loop::LoopError;
use crate::process::ProcessError;
use crate::process::fit::FitError;
use crate::render::Renderer;

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
    Optimize(#[from] OptimizeError),
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

/// All rows. With a renderer the physical plant is also run through rendered and measured frames.
///
/// # Errors
/// Inputs from which nothing can be computed.
pub fn run(
    inputs: &Inputs,
    problem: &OptimizeConfig,
    renderer: Option<&Renderer>,
) -> Result<Vec<Row>, ReproductionError> {
    inputs.check()?;
    let mut rows = deflection::rows(inputs)?;
    rows.extend(optimum::rows(inputs, problem)?);
    rows.extend(control::rows(&inputs.pid));
    rows.extend(physical::rows(&inputs.pid)?);
    if let Some(renderer) = renderer {
        rows.extend(frames::rows(&inputs.pid, renderer)?);
    }
    Ok(rows)
}
