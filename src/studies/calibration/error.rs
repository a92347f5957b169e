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
pub enum CalibrateError {
    /// A setting of the plan or of the gauge cannot be right.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// Frames that cannot be read.
    #[error("{0}")]
    Frames(String),
    /// The simulated optical setup cannot draw.
    #[error("simulate: {0}")]
    Render(#[from] RenderError),
    /// Dark and flat fields that are none.
    #[error("fields: {0}")]
    Fields(#[from] FlatFieldError),
    /// No photon transfer.
    #[error("fields: {0}")]
    Sensor(#[from] PhotonTransferError),
    /// Flat fields that are none of their exposures'.
    #[error("fields.flats: {0}")]
    Response(#[from] NoResponse),
    /// Frames whose files encode light in different ways.
    #[error(
        "{what}: the file encodes its grey values otherwise ({found}) than the frames before it ({before}); record all in one way"
    )]
    Encodings {
        /// Whose frames.
        what: String,
        /// Theirs.
        found: Encoding,
        /// That of those before.
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
    /// A pin from whose frames no edge-spread function can be learnt.
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
        /// Most rows that one travels.
        travel: f64,
        /// Tilt that would do, mrad.
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
    /// The masters give no calibration.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
}
