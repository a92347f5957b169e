//! All frames of a calibration encode light in one way: the offset of the edges holds for that one
//! alone.

use super::error::CalibrateError;
use super::plan::{CalibrationPlan, PinPlan, Position};
use super::recordings::Recordings;
use crate::frame::{Encoding, Frame};

/// Recordings whose frames are all encoded in one way.
pub(super) struct OneEncoding<'a> {
    inner: &'a mut dyn Recordings,
    /// That of the first frame seen.
    pub(super) encoding: Option<Encoding>,
}

impl<'a> OneEncoding<'a> {
    /// None seen yet.
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
