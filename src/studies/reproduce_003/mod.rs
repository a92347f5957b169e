//! Reproduction of the slender-shaft paper (Xue, Miao, Xue 2023): each of its figures beside ours.
//!
//! `ours` is computed on every run from [`Inputs`]: a changed input changes it and its verdict
//! ([`super::reproduction`]). A contradiction is shown by the paper's own figures alone
//! (`own_figures`); figures that are missed for a known reason are listed in `known`.

mod control;
mod curves;
mod deflection;
mod error;
mod frames;
mod inputs;
mod known;
mod optimum;
mod own_figures;
mod physical;

pub(crate) use curves::{Curve, Curves};
pub(crate) use error::ReproductionError;
pub(crate) use inputs::Inputs;
pub(crate) use known::KNOWN_MISSES;

use super::optimize::OptimizeConfig;
use super::reproduction::{self, Row};
use crate::render::Renderer;

/// Rows and curves of a reproduction.
#[derive(Clone, Debug)]
pub(crate) struct Reproduction {
    /// Every figure of the paper beside ours.
    pub rows: Vec<Row>,
    /// Curves for plots.
    pub curves: Curves,
}

/// All rows and curves. With a renderer the physical plant is also run through rendered and
/// measured frames.
///
/// # Errors
/// Inputs that are refused.
pub(crate) fn run(
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
