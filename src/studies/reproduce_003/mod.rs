//! Reproduction of the slender-shaft paper (Xue, Miao, Xue 2023): every figure of it beside ours.
//!
//! `ours` is computed when asked, from [`Inputs`]: a changed input changes it, and the verdict with it
//! ([`super::reproduction`]). A contradiction is shown by the paper's own figures alone (`own_figures`); figures that are missed
//! for a reason that is known stand in `known`.

mod control;
mod curves;
mod deflection;
mod frames;
mod inputs;
mod known;
mod optimum;
mod own_figures;
mod physical;

use thiserror::Error;

pub use curves::{Curve, Curves};
pub use frames::FrameRun;
pub use inputs::{Beam, Figure, Figures, Force, Handbook, Inputs, OptimumInput, PidInput, PlantInput};
pub use known::KNOWN_MISSES;

use super::factor::FactorError;
use super::optimize::{OptimizeConfig, OptimizeError};
use super::reproduction::{self, Row};
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

/// Rows and curves of a reproduction.
#[derive(Clone, Debug)]
pub struct Reproduction {
    /// Every figure of the paper beside ours.
    pub rows: Vec<Row>,
    /// What is drawn.
    pub curves: Curves,
}

/// All rows and curves. With a renderer the physical plant is also run through rendered and measured frames.
///
/// # Errors
/// Inputs from which nothing can be computed.
pub fn run(
    inputs: &Inputs,
    problem: &OptimizeConfig,
    renderer: Option<&Renderer>,
) -> Result<Reproduction, ReproductionError> {
    inputs.check()?;
    let model = deflection::Model::new(inputs, &problem.process.tool)?;
    let mut curves = Curves::of_figures(&model);
    let mut rows = own_figures::Printed::new(inputs, problem).rows();
    rows.extend(model.rows());
    rows.extend(optimum::rows(inputs, problem, &mut curves)?);
    rows.extend(control::rows(&inputs.pid));
    rows.extend(physical::rows(inputs, &mut curves)?);
    if let Some(renderer) = renderer {
        rows.extend(frames::rows(inputs, renderer, &mut curves)?);
    }
    reproduction::explain(&mut rows, &KNOWN_MISSES);
    Ok(Reproduction { rows, curves })
}
