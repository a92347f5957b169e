//! Arguments of the spindle's encoder, whose counts stand in `frames.csv`.

use super::input::Input;
use crate::cli::failure::Failure;
use crate::position::{EncoderDirection, EncoderSettings, LatchedAt};

/// Arguments of the encoder.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct EncoderArgs {
    /// Takes the spindle angles from encoder_count (and index, the count at the last index pulse)
    /// in frames.csv: counts of a turn, all edges counted.
    #[arg(long, value_name = "N")]
    counts_per_turn: Option<u32>,
    /// When the count of a frame was latched: exposure_start (default), exposure_end, frame_start.
    /// Angles are moved to mid-exposure.
    #[arg(long, value_name = "WHEN", value_parser = latched_at, requires = "counts_per_turn")]
    latched_at: Option<LatchedAt>,
    /// Counts fall while the spindle angle rises.
    #[arg(long, requires = "counts_per_turn")]
    falling_counts: bool,
    /// Frames that the encoder triggers a turn: a turn with a trigger ignored or doubled is void.
    #[arg(long, value_name = "N", requires = "counts_per_turn")]
    frames_per_turn: Option<u32>,
}

fn latched_at(word: &str) -> Result<LatchedAt, String> {
    match word {
        "exposure_start" => Ok(LatchedAt::ExposureStart),
        "exposure_end" => Ok(LatchedAt::ExposureEnd),
        "frame_start" => Ok(LatchedAt::FrameStart),
        _ => Err("exposure_start, exposure_end or frame_start is right".to_owned()),
    }
}

impl EncoderArgs {
    /// The encoder that is stated.
    ///
    /// # Errors
    /// Exit 2 for values out of range, and for a stream: the counts of a turn are judged together.
    pub(super) fn encoder(&self, input: &Input) -> Result<Option<EncoderSettings>, Failure> {
        let Some(counts_per_turn) = self.counts_per_turn else { return Ok(None) };
        if input.is_stream() {
            return Err(Failure::refuse(
                "--counts-per-turn needs frames that are there with their frames.csv, not a stream (--follow, -)",
            ));
        }
        let settings = EncoderSettings {
            direction: if self.falling_counts { EncoderDirection::Falling } else { EncoderDirection::Rising },
            latched_at: self.latched_at.unwrap_or_default(),
            frames_per_turn: self.frames_per_turn,
            ..EncoderSettings::new(counts_per_turn)
        };
        settings.validate().map_err(Failure::refuse)?;
        Ok(Some(settings))
    }
}
