//! Why there is no calibration, or none that fits.

use thiserror::Error;

use crate::frame::{BindingError, Encoding};
use crate::gauge::limit::limits;

limits! {
    /// What masters must differ by.
    CalibrationLimits = "calibration";
    /// Difference of the masters' shadows, px, from which on scale and offset are separated: of
    /// widths known to 0.01 px the scale is then known to √2·0.01/8 = 0.2 %.
    least_spread_px: f64 = 8.0;
}

/// Version of the file format.
pub(crate) const CALIBRATION_VERSION: u32 = 1;

/// Why there is no calibration.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CalibrationError {
    /// A certificate without information.
    #[error("master {master}: diameter, U and k of a certificate must be finite and above 0")]
    Certificate {
        /// Number of the master, from 1.
        master: usize,
    },
    /// Too few masters.
    #[error("{found} masters; scale and edge offset need two or more")]
    TooFew {
        /// Masters given.
        found: usize,
    },
    /// Masters of one size.
    #[error(
        "the masters' shadows differ by {spread_px:.1} px; {} px or more are needed to tell scale from edge offset",
        CalibrationLimits::get().least_spread_px
    )]
    SameSize {
        /// Largest minus smallest width, px.
        spread_px: f64,
    },
    /// No frame shows the master.
    #[error("no frame shows the master of {diameter_mm} mm with both edges")]
    Unseen {
        /// Certified diameter, mm.
        diameter_mm: f64,
    },
    /// The file is no calibration.
    #[error("not a calibration: {0}")]
    Parse(#[from] serde_json::Error),
    /// The file is of another version.
    #[error("calibration version {found}; this program reads version {CALIBRATION_VERSION}")]
    Version {
        /// Version in the file.
        found: u32,
    },
    /// Frames whose grey values were encoded otherwise than the masters'.
    #[error(
        "the file encodes its grey values otherwise than the calibration's frames: {found} here, which there {calibrated}; record as then, or calibrate anew"
    )]
    OtherEncoding {
        /// The frame's encoding.
        found: Encoding,
        /// What is known of the masters'.
        calibrated: String,
    },
    /// Edges of another model than the masters'.
    #[error(
        "the masters' edges were fitted by the edge-spread function {calibrated}, asked for is {asked}: measure as calibrated (--esf), or calibrate anew"
    )]
    OtherEdgeModel {
        /// Name of the masters' model.
        calibrated: String,
        /// Name of the model asked for.
        asked: &'static str,
    },
    /// Another table than the masters'.
    #[error(
        "the masters' edges were fitted by another table of the edge-spread function than --esf gives: measure as calibrated (leave --esf out), or calibrate anew"
    )]
    OtherEdgeTable,
    /// The calibration belongs to other optics.
    #[error("the calibration is of optics {found:?}, the frames are of {expected:?}; calibrate these optics")]
    OtherOptics {
        /// Optics id in the file.
        found: String,
        /// Optics in use.
        expected: String,
    },
    /// Frames of another camera, or of one that is set otherwise.
    #[error(transparent)]
    OtherCamera(Box<BindingError>),
    /// A condition that cannot be.
    #[error("calibration key bench.{0}")]
    Setting(String),
    /// A number that cannot be.
    #[error("calibration key {key} = {value} is impossible; right would be {right}")]
    Value {
        /// The key.
        key: &'static str,
        /// The value.
        value: f64,
        /// What would be right.
        right: &'static str,
    },
}

impl From<BindingError> for CalibrationError {
    fn from(error: BindingError) -> Self {
        Self::OtherCamera(Box::new(error))
    }
}
