//! Models of a machine's errors side by side: the paper's nets, splines, polynomials and functions
//! through the chain, each by its error where it was not given samples.
//!
//! In: a machine, the number of positions and the noise of a sample. Out: [`Models`]: the paper's
//! four curves A to D and both components over the working space. `curve_model` is one curve by one
//! model, `paper_samples` what the paper would measure on this machine, `curves` and `fields` the
//! comparisons. A constant is the set-up of the tool: it is taken out of every comparison. One more
//! model of a curve is a variant of [`CurveKind`]; one of the working space a row of `fields`.

mod asked;
mod curve_model;
mod curves;
mod fields;
mod paper_samples;

use serde::Serialize;

pub(crate) use asked::ModelsAsked;
pub(crate) use curve_model::{CurveKind, CurveModel};
pub(crate) use curves::CurveRow;
pub(crate) use fields::FieldRow;

use super::config::MachineStudyConfig;
use super::prepared::Prepared;
use crate::setting::SettingError;

/// The models, compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Models {
    /// Standard deviation of a sample, µm.
    pub noise_um: f64,
    /// Positions of either slide.
    pub positions: usize,
    /// The paper's curves by every model.
    pub curves: Vec<CurveRow>,
    /// Both components over the working space by every model.
    pub fields: Vec<FieldRow>,
}

impl MachineStudyConfig {
    /// Compares the models on the machine.
    ///
    /// # Errors
    /// The first value that cannot be right.
    pub(crate) fn models(&self, asked: &ModelsAsked) -> Result<Models, SettingError> {
        asked.check()?;
        let machine = Prepared::of(self)?;
        let samples = paper_samples::PaperSamples::of(&machine, self.part.radius_mm(), asked);
        Ok(Models {
            noise_um: asked.noise_um,
            positions: asked.positions,
            curves: curves::rows(&samples, asked),
            fields: fields::rows(&samples, asked),
        })
    }
}
