//! What finds the land in a strip: a [`Forest`], or a network of the user's (`network`).

use super::error::FlankError;
use super::forest::Forest;
use super::land::{Land, land};
use super::raster::Raster;
use super::strip::Frame;

/// Errors of a model on flanks that it was not trained on, root mean square, µm; NaN where it
/// states none, so that no uncertainty follows and no verdict is proven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ModelErrors {
    /// Of VB.
    pub vb_um: f64,
    /// Of VBmax.
    pub vb_max_um: f64,
}

/// A model of the land.
pub(crate) trait LandModel: Sync {
    /// The border of the land in a strip; `inside` are the rows of each column within the image.
    ///
    /// # Errors
    /// What the model cannot be asked, or an answer that is none.
    fn land(&self, strip: &Raster, frame: &Frame, inside: &[usize]) -> Result<Land, FlankError>;

    /// What it states of its errors.
    fn errors(&self) -> ModelErrors;
}

impl LandModel for Forest {
    fn land(&self, strip: &Raster, frame: &Frame, inside: &[usize]) -> Result<Land, FlankError> {
        Ok(land(strip, frame, inside, self))
    }

    fn errors(&self) -> ModelErrors {
        ModelErrors { vb_um: self.facts.vb_error_um, vb_max_um: self.facts.vb_max_error_um }
    }
}
