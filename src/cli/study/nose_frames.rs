//! The frames of a study of noses, with what is true of them.

use serde_json::Value;

use crate::cli::failure::Failure;
use crate::cli::input_output::{StudyFolder, json_text};
use crate::cli::render::frame_files::{FileFormat, encode};
use crate::frame::Frame;
use crate::render::insert::Truth;

/// Writes frames as they are drawn, where a folder is asked for.
pub(super) struct NoseFrames<'a> {
    folder: Option<&'a StudyFolder>,
    um_per_px: f64,
    truths: Vec<Value>,
    failed: Option<Failure>,
}

impl<'a> NoseFrames<'a> {
    pub(super) fn new(folder: Option<&'a StudyFolder>, um_per_px: f64) -> Self {
        Self { folder, um_per_px, truths: Vec::new(), failed: None }
    }

    /// Writes a frame; the first failure is kept for [`Self::finish`].
    pub(super) fn keep(&mut self, frame: &Frame, truth: &Truth) {
        let Some(folder) = self.folder.filter(|_| self.failed.is_none()) else { return };
        if let Err(failure) = self.write(folder, frame, truth) {
            self.failed = Some(failure);
        }
    }

    fn write(&mut self, folder: &StudyFolder, frame: &Frame, truth: &Truth) -> Result<(), Failure> {
        let file = encode(frame, FileFormat::Png16, self.um_per_px).map_err(Failure::fail)?;
        folder.write(&format!("frames/{:06}.png", self.truths.len()), &file)?;
        self.truths.push(serde_json::to_value(truth).map_err(Failure::fail)?);
        Ok(())
    }

    /// Writes the list of what is true.
    ///
    /// # Errors
    /// What failed of the frames, or exit 3 where the disk refuses.
    pub(super) fn finish(self) -> Result<(), Failure> {
        match (self.failed, self.folder) {
            (Some(failure), _) => Err(failure),
            (None, Some(folder)) => folder.write("truth.json", (json_text(&self.truths)? + "\n").as_bytes()),
            (None, None) => Ok(()),
        }
    }
}
