//! Checks that all frames of a calibration have the same encoding of light, for which alone the
//! edge offset is valid.

use super::error::CalibrateError;
use super::plan::{CalibrationPlan, PinPlan, Position};
use super::recordings::Recordings;
use crate::frame::{Encoding, Frame};

/// Recordings whose frames all have the same encoding.
pub(super) struct OneEncoding<'a> {
    inner: &'a mut dyn Recordings,
    /// Encoding of the first frame.
    pub(super) encoding: Option<Encoding>,
}

impl<'a> OneEncoding<'a> {
    /// Recordings before the first frame.
    pub(super) fn new(inner: &'a mut dyn Recordings) -> Self {
        Self { inner, encoding: None }
    }

    fn checked(&mut self, what: &str, frames: Vec<Frame>) -> Result<Vec<Frame>, CalibrateError> {
        for frame in &frames {
            let found = frame.meta.encoding;
            let before = *self.encoding.get_or_insert(found);
            if !before.is_same(&found) {
                return Err(CalibrateError::Encodings { what: what.to_owned(), found, before });
            }
        }
        Ok(frames)
    }
}

impl Recordings for OneEncoding<'_> {
    fn pin(
        &mut self,
        index: usize,
        pin: &PinPlan,
        position: &Position,
    ) -> Result<Vec<Frame>, CalibrateError> {
        let frames = self.inner.pin(index, pin, position)?;
        self.checked(&pin.name, frames)
    }

    fn dark(&mut self, plan: &CalibrationPlan) -> Result<Vec<Frame>, CalibrateError> {
        let frames = self.inner.dark(plan)?;
        self.checked("fields.dark", frames)
    }

    fn flat(&mut self, plan: &CalibrationPlan, index: usize) -> Result<Vec<Frame>, CalibrateError> {
        let frames = self.inner.flat(plan, index)?;
        self.checked(&format!("fields.flats[{index}]"), frames)
    }
}
