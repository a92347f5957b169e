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

/// Groups of rows that are computed without frames.
const GROUPS: usize = 5;

/// Steps of [`run`]: groups of rows and, with frames, passes.
pub(crate) fn steps_in_all(with_frames: bool) -> usize {
    GROUPS + if with_frames { frames::RUNS.len() * physical::PASSES } else { 0 }
}

/// All rows and curves. With a renderer the physical plant is also run through rendered and
/// measured frames. `done` is called after each step.
///
/// # Errors
/// Inputs that are refused.
pub(crate) fn run(
    inputs: &Inputs,
    problem: &OptimizeConfig,
    renderer: Option<&Renderer>,
    done: &dyn Fn(),
) -> Result<Reproduction, ReproductionError> {
    inputs.check()?;
    let model = deflection::Model::new(inputs, &problem.process.tool)?;
    let mut curves = Curves::of_figures(&model);
    let mut rows: Vec<Row> = Vec::new();
    let mut add = |group: Vec<Row>| {
        rows.extend(group);
        done();
    };
    add(own_figures::Printed::new(inputs, problem).rows());
    add(model.rows());
    add(optimum::rows(inputs, problem, &mut curves)?);
    add(control::rows(&inputs.pid));
    add(physical::rows(inputs, &mut curves)?);
    if let Some(renderer) = renderer {
        rows.extend(frames::rows(inputs, renderer, &mut curves, done)?);
    }
    reproduction::explain(&mut rows, &KNOWN_MISSES);
    Ok(Reproduction { rows, curves })
}
