//! Arguments of the spindle's encoder: its counts in `frames.csv`, timed samples of it beside the
//! frames, or the numbers of its triggers.

use std::path::PathBuf;

use super::encoder_samples::SampleTable;
use super::index_table::IndexTable;
use crate::cli::failure::Failure;
use crate::position::{EncoderDirection, EncoderSettings, LatchedAt, SampledEncoder, TriggerCount};
use crate::source::live::{Binding, Bound, IndexTimes, Producer};

/// The encoder of an input: its counts in the table of the frames, or beside them.
#[derive(Default)]
pub(crate) struct EncoderOf {
    pub(super) in_table: Option<EncoderSettings>,
    pub(super) beside: Option<Binding>,
}

/// Arguments of the encoder.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct EncoderArgs {
    /// Takes the spindle angles from an encoder: counts of a turn, all edges counted. The counts
    /// stand in frames.csv (encoder_count and index, the count at the last index pulse), or in
    /// --encoder-samples; --encoder-triggers needs none.
    #[arg(long, value_name = "N")]
    counts_per_turn: Option<u32>,
    /// When the count of a frame was latched, or with --encoder-samples the time of a frame, or
    /// with --encoder-triggers its trigger: exposure_start (default), exposure_end, frame_start.
    /// Angles are moved to mid-exposure.
    #[arg(long, value_name = "WHEN", value_parser = latched_at, requires = "counts_per_turn")]
    latched_at: Option<LatchedAt>,
    /// From the trigger to the start of exposure, µs; with --latched-at frame_start.
    #[arg(long, value_name = "US", requires = "latched_at")]
    frame_start_delay_us: Option<f64>,
    /// Counts fall while the spindle angle rises.
    #[arg(long, requires = "counts_per_turn")]
    falling_counts: bool,
    /// Spindle angle at the index pulse, degrees. 0 unless given.
    #[arg(long, value_name = "DEG", requires = "counts_per_turn", allow_negative_numbers = true)]
    index_deg: Option<f64>,
    /// Frames that the encoder triggers a turn: a turn with a trigger ignored or doubled is void.
    #[arg(long, value_name = "N", requires = "counts_per_turn")]
    frames_per_turn: Option<u32>,
    /// Binds frames to the samples of the encoder in this table (CSV: count and, where known, index
    /// and z_mm, with times in t_ns or device_t_ns, the clock of the frames, or in host_t_ns, this
    /// machine's), which may grow meanwhile. Angles and z are interpolated at mid-exposure.
    #[arg(
        long,
        value_name = "FILE.csv",
        requires = "counts_per_turn",
        conflicts_with_all = ["encoder_triggers", "frames_per_turn"]
    )]
    encoder_samples: Option<PathBuf>,
    /// Binds frames by the numbers of the encoder's triggers: FIRST is the number of the first
    /// frame after an index pulse, from 0. The times of the frames show a trigger that was ignored
    /// or doubled.
    #[arg(long, value_name = "FIRST", requires = "frames_per_turn")]
    encoder_triggers: Option<u64>,
    /// Times of the encoder's index pulses (CSV: t_ns or device_t_ns, the clock of the frames, or
    /// host_t_ns, this machine's; a row a pulse), which may grow meanwhile: each checks the count
    /// of triggers, and a turn that it contradicts is void. Without it a quarter of the step from
    /// trigger to trigger is in the uncertainty of the angles.
    #[arg(long, value_name = "FILE.csv", requires = "encoder_triggers")]
    encoder_index: Option<PathBuf>,
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
    /// Exit 2 for values out of range.
    fn settings(&self) -> Result<Option<EncoderSettings>, Failure> {
        let Some(counts_per_turn) = self.counts_per_turn else { return Ok(None) };
        let settings = EncoderSettings {
            direction: if self.falling_counts { EncoderDirection::Falling } else { EncoderDirection::Rising },
            latched_at: self.latched_at.unwrap_or_default(),
            frame_start_delay_us: self.frame_start_delay_us.unwrap_or(0.0),
            index_deg: self.index_deg.unwrap_or(0.0),
            frames_per_turn: self.frames_per_turn,
            ..EncoderSettings::new(counts_per_turn)
        };
        settings.validate().map_err(Failure::refuse)?;
        Ok(Some(settings))
    }

    /// Whether an encoder stands beside the frames.
    pub(crate) fn is_given(&self) -> bool {
        self.encoder_samples.is_some() || self.encoder_triggers.is_some()
    }

    /// The table of samples or of index pulses, which no output may replace.
    pub(super) fn file(&self) -> Option<PathBuf> {
        self.encoder_samples.clone().or(self.encoder_index.clone())
    }

    /// The encoder whose counts stand in the table of the frames.
    ///
    /// # Errors
    /// Exit 2 for values out of range, and for a stream: it has no table, whose turns are judged
    /// together.
    pub(crate) fn in_table(&self, is_stream: bool) -> Result<Option<EncoderSettings>, Failure> {
        let settings = self.settings()?.filter(|_| !self.is_given());
        if settings.is_some() && is_stream {
            return Err(Failure::refuse(
                "--counts-per-turn takes counts from the frames.csv of frames that are there; of a stream give \
                 --encoder-samples FILE.csv, or --encoder-triggers FIRST with --frames-per-turn N",
            ));
        }
        Ok(settings)
    }

    /// The encoder of an input.
    ///
    /// # Errors
    /// As [`Self::in_table`] and [`Self::binding`].
    pub(super) fn of_input(&self, is_stream: bool) -> Result<EncoderOf, Failure> {
        Ok(EncoderOf { in_table: self.in_table(is_stream)?, beside: self.binding()? })
    }

    /// How frames are bound to an encoder beside them; `None` where there is none.
    ///
    /// # Errors
    /// Exit 2 for values out of range, 3 for a table that cannot be read.
    pub(crate) fn binding(&self) -> Result<Option<Binding>, Failure> {
        let Some(settings) = self.settings()? else { return Ok(None) };
        if let Some(path) = &self.encoder_samples {
            std::fs::File::open(path).map_err(|e| Failure::fail(format!("{}: {e}", path.display())))?;
            let table = SampleTable::new(path);
            return Ok(Some(Binding::Samples(SampledEncoder::new(settings), Box::new(table))));
        }
        let Some(first) = self.encoder_triggers else { return Ok(None) };
        let count = TriggerCount::new(settings, first).map_err(Failure::refuse)?;
        let Some(path) = &self.encoder_index else {
            tracing::warn!(
                "no index pulse checks the count of triggers: a quarter of a step is in the uncertainty of every \
                 angle; give --encoder-index FILE.csv"
            );
            return Ok(Some(Binding::Triggers(count, None)));
        };
        let table = IndexTable::open(path).map_err(Failure::refuse)?;
        let index: Box<dyn IndexTimes> = Box::new(table);
        Ok(Some(Binding::Triggers(count.with_index(), Some(index))))
    }
}

/// A source with its frames bound, where that is asked for; `is_live`: it goes on whether its
/// frames are taken or not.
pub(crate) fn bound(source: Box<dyn Producer>, binding: Option<Binding>, is_live: bool) -> Box<dyn Producer> {
    match binding {
        Some(binding) => Box::new(Bound::new(source, binding, is_live)),
        None => source,
    }
}
