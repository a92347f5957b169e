//! The frames of a calibration in folders, and a bar that counts recordings.

use std::collections::HashSet;
use std::path::PathBuf;

use indicatif::ProgressBar;

use crate::cli::terminal::progress;
use crate::frame::Frame;
use crate::source::{Channel, FileFrames, listing};
use crate::studies::calibration::{CalibrateError, CalibrationPlan, PinPlan, Position, Recordings};

/// Recordings with a bar on a terminal that counts them.
pub(super) struct Watched<'a> {
    recordings: &'a mut dyn Recordings,
    bar: ProgressBar,
}

impl<'a> Watched<'a> {
    /// Recordings of a plan before the first.
    pub(super) fn new(plan: &CalibrationPlan, recordings: &'a mut dyn Recordings) -> Self {
        let positions: usize = plan.masters.iter().chain(&plan.check).map(|pin| pin.positions.len()).sum();
        let fields = plan.fields.flats.len() + usize::from(!plan.fields.flats.is_empty());
        let bar = progress::bar((positions + fields) as u64, "measuring", "recordings");
        Self { recordings, bar }
    }
}

impl Drop for Watched<'_> {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

impl Recordings for Watched<'_> {
    fn pin(
        &mut self,
        index: usize,
        pin: &PinPlan,
        position: &Position,
    ) -> Result<Vec<Frame>, CalibrateError> {
        self.recordings.pin(index, pin, position).inspect(|_| self.bar.inc(1))
    }

    fn dark(&mut self, plan: &CalibrationPlan) -> Result<Vec<Frame>, CalibrateError> {
        self.recordings.dark(plan).inspect(|_| self.bar.inc(1))
    }

    fn flat(&mut self, plan: &CalibrationPlan, index: usize) -> Result<Vec<Frame>, CalibrateError> {
        self.recordings.flat(plan, index).inspect(|_| self.bar.inc(1))
    }
}

/// Frames in the folders that a plan names.
pub(super) struct RecordedFrames {
    folder: PathBuf,
    channel: Option<Channel>,
    /// Notes on the files already written.
    said: HashSet<String>,
}

impl RecordedFrames {
    /// Frames in folders below this one, of colour images this channel.
    pub(super) fn new(folder: PathBuf, channel: Option<Channel>) -> Self {
        Self { folder, channel, said: HashSet::new() }
    }

    fn read(&mut self, path: Option<&PathBuf>) -> Result<Vec<Frame>, CalibrateError> {
        let Some(path) = path else { return Ok(Vec::new()) };
        let frames = |e: &dyn std::fmt::Display| CalibrateError::Frames(e.to_string());
        let images = listing(&self.folder.join(path)).map_err(|e| frames(&e))?.images;
        let mut source = FileFrames::new(images).of_channel(self.channel);
        let mut all = Vec::new();
        while let Some(read) = source.next_stored() {
            let stored = read.map_err(|e| frames(&e))?;
            for said in source.take_notices().into_iter().chain(stored.changed) {
                if self.said.insert(said.clone()) {
                    tracing::warn!("{}: {said}; this is said once", path.display());
                }
            }
            all.push(stored.frame);
        }
        Ok(all)
    }
}

impl Recordings for RecordedFrames {
    fn pin(&mut self, _: usize, _: &PinPlan, position: &Position) -> Result<Vec<Frame>, CalibrateError> {
        self.read(position.frames.as_ref())
    }

    fn dark(&mut self, plan: &CalibrationPlan) -> Result<Vec<Frame>, CalibrateError> {
        self.read(plan.fields.dark.as_ref())
    }

    fn flat(&mut self, plan: &CalibrationPlan, index: usize) -> Result<Vec<Frame>, CalibrateError> {
        self.read(plan.fields.flats[index].frames.as_ref())
    }
}
