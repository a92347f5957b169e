//! Where the frames of a calibration come from.

use super::error::CalibrateError;
use super::plan::{CalibrationPlan, PinPlan, Position};
use crate::frame::Frame;

/// Where the frames of a calibration come from.
pub trait Recordings {
    /// Frames of pin `index` (masters first, then the check pin) at a position.
    ///
    /// # Errors
    /// Where they cannot be had.
    fn pin(&mut self, index: usize, pin: &PinPlan, position: &Position)
    -> Result<Vec<Frame>, CalibrateError>;

    /// Dark frames; none where none were taken.
    ///
    /// # Errors
    /// Where they cannot be had.
    fn dark(&mut self, plan: &CalibrationPlan) -> Result<Vec<Frame>, CalibrateError>;

    /// Frames of flat field `index` of the plan.
    ///
    /// # Errors
    /// Where they cannot be had.
    fn flat(&mut self, plan: &CalibrationPlan, index: usize) -> Result<Vec<Frame>, CalibrateError>;
}
