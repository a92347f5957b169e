//! What `measure` warns of on stderr: refused frames, and what their measurements warn of.

use crate::cli::failure::Failure;
use crate::measurement::{Measurement, Stream};

/// Warnings of the frames as they come, and how many of them could not be measured.
#[derive(Debug, Default)]
pub(super) struct FrameWarnings {
    frames: usize,
    refused: usize,
    /// Why the first frame was refused, if it was.
    first_refusal: Option<String>,
    has_no_zone: bool,
}

impl FrameWarnings {
    /// Counts a frame; whether one could be measured so far.
    pub(super) fn count(&mut self, frame: &Measurement) -> bool {
        self.frames += 1;
        if let Some(refusal) = &frame.refusal {
            self.refused += 1;
            self.first_refusal.get_or_insert_with(|| refusal.why.clone());
        }
        self.refused < self.frames
    }

    /// Warns of a frame; that no uncertainty proves conformity once.
    pub(super) fn report(&mut self, frame: &Measurement) {
        if let Some(refusal) = &frame.refusal {
            tracing::warn!("{}", refusal.why);
        }
        for warning in &frame.warnings {
            if warning.is_of_image() {
                tracing::warn!("frame {}: {warning}", frame.frame);
            } else {
                tracing::warn!("frame {}: {warning}", frame.frame_id);
            }
        }
        for jump in &frame.jumps {
            tracing::warn!("frame {}: {jump}", frame.frame_id);
        }
        if let (Some(error), false) = (&frame.acceptance_zone, self.has_no_zone) {
            tracing::warn!("{error}");
            self.has_no_zone = true;
        }
    }

    /// Fails with the first frame's reason where none could be measured.
    pub(super) fn check_measured(&self) -> Result<(), Failure> {
        if self.refused < self.frames {
            return Ok(());
        }
        let first = self.first_refusal.as_deref().unwrap_or("no frame");
        Err(match self.frames {
            0 | 1 => Failure::fail(first),
            n => Failure::fail(format!("none of {n} frames can be measured; the first: {first}")),
        })
    }
}

/// Warns where an edge-spread function could not be determined from the frame.
pub(super) fn report_unlearnt(stream: &Stream) {
    let count = stream.unlearnt();
    if count > 0 {
        tracing::warn!(
            "{count} frames measured with a Gaussian: their edges show too few sub-pixel phases to learn from; tilt the part by a pixel or more over the field"
        );
    }
}

/// Warns where sizes are judged without a calibration.
pub(super) fn report_uncalibrated(stream: &Stream) {
    if stream.judges_uncalibrated() {
        tracing::warn!(
            "scale and edge offset are not calibrated: U does not hold their uncertainty, and what is judged with it is \
             only as good as they are; --calibration states both"
        );
    }
}
