//! What `measure` warns of on stderr: refused frames, and what their measurements warn of.

use crate::cli::failure::Failure;
use crate::measurement::{Measurement, Stream};

/// Warns of refused frames; fails with the first one's reason where none could be measured.
pub(super) fn report_refusals<'a>(frames: impl Iterator<Item = &'a Measurement>) -> Result<(), Failure> {
    let (mut count, mut refusals) = (0, Vec::new());
    for frame in frames {
        count += 1;
        refusals.extend(frame.refusal.as_ref().map(|refusal| refusal.why.as_str()));
    }
    if refusals.len() == count {
        let first = refusals.first().copied().unwrap_or("no frame");
        return Err(match refusals.len() {
            0 | 1 => Failure::fail(first),
            n => Failure::fail(format!("none of {n} frames can be measured; the first: {first}")),
        });
    }
    for text in refusals {
        tracing::warn!("{text}");
    }
    Ok(())
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

/// The warnings of every frame in their order; that no uncertainty proves conformity once.
pub(super) fn report_frames<'a>(frames: impl Iterator<Item = &'a Measurement>) {
    let mut no_zone_told = false;
    for frame in frames {
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
        if let (Some(error), false) = (&frame.acceptance_zone, no_zone_told) {
            tracing::warn!("{error}");
            no_zone_told = true;
        }
    }
}
