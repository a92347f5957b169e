//! A source of the frames of a calibration.

use super::error::CalibrateError;
use super::plan::{CalibrationPlan, PinPlan, Position};
use crate::frame::Frame;

/// A source of the frames of a calibration.
pub(crate) trait Recordings {
    /// Frames of pin `index` (masters first, then the check pin) at a position.
    ///
    /// # Errors
    /// Where they are unavailable.
    fn pin(&mut self, index: usize, pin: &PinPlan, position: &Position)
    -> Result<Vec<Frame>, CalibrateError>;

    /// Dark frames; empty where there are none.
    ///
    /// # Errors
    /// Where they are unavailable.
    fn dark(&mut self, plan: &CalibrationPlan) -> Result<Vec<Frame>, CalibrateError>;

    /// Frames of flat field `index` of the plan.
    ///
    /// # Errors
    /// Where they are unavailable.
    fn flat(&mut self, plan: &CalibrationPlan, index: usize) -> Result<Vec<Frame>, CalibrateError>;
}
