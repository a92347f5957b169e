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
    /// Optics whose limbs cannot be computed.
    #[error("[optics.esf.{family}]: {why}")]
    NoLimb {
        /// The family, as in `[optics.esf]`.
        family: &'static str,
        /// What is missing, and what would be right.
        why: &'static str,
    },
    /// A limb that the gauge's edge cannot be fitted to.
    #[error(
        "the limb of Ø{diameter_mm:.4} mm, {axis_y_mm} mm before the plane of focus, cannot be fitted by the gauge's edge"
    )]
    NotFitted {
        /// Its diameter, mm.
        diameter_mm: f64,
        /// Distance of its axis from the plane of focus, mm.
        axis_y_mm: f64,
    },
    /// Masters that do not determine a budget.
    #[error(
        "its masters give no budget of a diameter of {0} mm: --diameter-mm must lie in the calibrated field"
    )]
    NoBudget(f64),
}
