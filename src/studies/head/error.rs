//! Why heads cannot be compared.

use thiserror::Error;

use crate::render::RenderError;
use crate::setting::SettingError;
use crate::studies::calibration::CalibrateError;

/// Why a head cannot be studied.
#[derive(Debug, Error)]
pub(crate) enum HeadError {
    /// A setting of its config.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// Its optics or frames.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// Its masters.
    #[error("masters: {0}")]
    Calibrate(#[from] CalibrateError),
    /// Masters that do not determine a budget.
    #[error(
        "its masters give no budget of a diameter of {0} mm: --diameter-mm must lie in the calibrated field"
    )]
    NoBudget(f64),
}
