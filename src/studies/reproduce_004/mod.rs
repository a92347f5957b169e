//! Reproduction of the paper on tool wear by vision (Zhang, Lu, Xia, Zhang, Zhu 2025): the figures
//! of its flank, nose, compensation and workpieces beside ours.
//!
//! In: [`Inputs`], what the paper prints, and the angles of the cones where they are stated. Out:
//! rows with verdicts ([`super::reproduction`]) and curves. The paper's ways of measuring are those
//! of `gauge::nose::paper` and `gauge::flank::paper`; `flank_rows` has Table 1, `nose_rows` scale,
//! radii and line detector, `seat` how a holder tilts an insert, `parts` Table 4, `lathe` Tables 2
//! and 3, `contradictions` thirteen places where the paper disagrees with itself (c01 to c13),
//! `model` the paper's nose in e(a) of `tool`. A further figure is a row in the file of its
//! subject.

mod contradictions;
mod curves;
mod error;
mod flank_rows;
mod inputs;
mod lathe;
mod model;
mod nose_rows;
mod parts;
mod seat;

pub(crate) use curves::{Curve, Curves, PartError};
pub(crate) use error::ReproductionError;
pub(crate) use inputs::{Inputs, PrintedPart};

use super::reproduction::Row;

/// Rows and curves.
#[derive(Clone, Debug)]
pub(crate) struct Reproduction {
    /// Every figure of the paper beside ours.
    pub rows: Vec<Row>,
    /// Curves for plots.
    pub curves: Curves,
}

/// Computes every row and curve.
///
/// # Errors
/// Inputs that are refused.
pub(crate) fn run(inputs: &Inputs) -> Result<Reproduction, ReproductionError> {
    inputs.check()?;
    let model = model::Model::new(inputs)?;
    let mut rows = nose_rows::rows(inputs, &model::geometry(inputs));
    rows.extend(flank_rows::rows(inputs));
    rows.extend(parts::rows(inputs));
    rows.extend(lathe::rows(inputs));
    rows.extend(contradictions::rows(inputs, &model.round()?));
    let (own, curves) = model.rows()?;
    rows.extend(own);
    Ok(Reproduction { rows, curves })
}
