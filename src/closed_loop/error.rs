//! Errors of the closed loop.

use thiserror::Error;

use crate::cell::CellError;
use crate::control::ControlError;
use crate::control::external::ProgramError;
use crate::frame::SourceError;
use crate::gauge::CalibrationError;
use crate::setting::SettingError;

/// Why a loop cannot continue.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LoopError {
    /// A setting of the job or of the gauge is out of range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The cell failed.
    #[error(transparent)]
    Cell(#[from] CellError),
    /// A frame did not arrive.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The gauge cannot be calibrated.
    #[error("calibration: {0}")]
    Calibration(#[from] CalibrationError),
    /// The probe cannot be calibrated.
    #[error("calibration: {0}")]
    Probe(#[from] crate::probe::CalibrationError),
    /// A calibration of another instrument than the job's.
    #[error("calibration: the job measures with {0}, the calibration given is none of it")]
    OtherInstrument(&'static str),
    /// A master pin could not be measured.
    #[error("calibration: no frame of master pin {pin} could be measured: {why}")]
    Master {
        /// Number of the pin, from 1.
        pin: usize,
        /// The gauge's reason.
        why: String,
    },
    /// The controller refuses its settings.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// The program behind the controller failed.
    #[error(transparent)]
    Program(#[from] ProgramError),
    /// A recorded pass does not fit the job.
    #[error("the recorded pass {pass} has {found} stations, the job {expected}")]
    Replay {
        /// Pass, from 1.
        pass: u32,
        /// Stations in the record.
        found: usize,
        /// Stations of the job.
        expected: usize,
    },
}
