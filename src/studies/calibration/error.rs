//! Why there is no calibration.

use thiserror::Error;

use crate::frame::Encoding;
use crate::gauge::CalibrationError;
use crate::gauge::photon_transfer::PhotonTransferError;
use crate::gauge::sensor::{FlatFieldError, NoResponse};
use crate::render::RenderError;
use crate::setting::SettingError;

/// Why there is no calibration.
#[derive(Debug, Error)]
#[non_exhaustive]
pub(crate) enum CalibrateError {
    /// A setting of the plan or of the gauge is out of range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// Frames that cannot be read.
    #[error("{0}")]
    Frames(String),
    /// The simulated optical setup cannot render.
    #[error("simulate: {0}")]
    Render(#[from] RenderError),
    /// Dark and flat fields that are refused.
    #[error("fields: {0}")]
    Fields(#[from] FlatFieldError),
    /// The photon transfer cannot be evaluated.
    #[error("fields: {0}")]
    Sensor(#[from] PhotonTransferError),
    /// Flat fields that do not match their exposures.
    #[error("fields.flats: {0}")]
    Response(#[from] NoResponse),
    /// Frames whose files encode light in different ways.
    #[error(
        "{what}: the file encodes its grey values otherwise ({found}) than the frames before it ({before}); record all in one way"
    )]
    Encodings {
        /// The pin or field of the frames.
        what: String,
        /// Their encoding.
        found: Encoding,
        /// Encoding of the frames before.
        before: Encoding,
    },
    /// A pin that cannot be measured.
    #[error("{pin}: no frame shows it: {why}")]
    Pin {
        /// Its name.
        pin: String,
        /// The gauge's reason.
        why: String,
    },
    /// A pin from whose frames no edge-spread function can be estimated.
    #[error(
        "{pin}: none of its {frames} frame(s) teaches the edge-spread function: each edge must travel {needed} rows or more along the frame, so \
         that all sub-pixel phases show, and these travel {travel:.2}: lay the pin obliquely by {tilt_mrad:.1} mrad or more (limit_tilt_mrad \
         where it is simulated), or calibrate with --esf gaussian or a file"
    )]
    Unlearnt {
        /// Its name.
        pin: String,
        /// Its frames.
        frames: usize,
        /// Rows that an edge must travel.
        needed: f64,
        /// Largest travel found, rows.
        travel: f64,
        /// Sufficient tilt, mrad.
        tilt_mrad: f64,
    },
    /// Frames of different sizes.
    #[error(
        "{pin}: a frame of {found:?} rows x columns after frames of {expected:?}; one calibration is of one window"
    )]
    Size {
        /// The pin.
        pin: String,
        /// Rows and columns found.
        found: (usize, usize),
        /// Rows and columns expected.
        expected: (usize, usize),
    },
    /// The masters determine no calibration.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
}
