//! The spindle's encoder: the `[scan.encoder]` table, and an angle from a count.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::setting::{SettingError, require};

/// The instant at which the count of a frame was latched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LatchedAt {
    /// When the exposure begins.
    #[default]
    ExposureStart,
    /// When the exposure ends.
    ExposureEnd,
    /// When the frame is triggered, `frame_start_delay_us` before its exposure begins.
    FrameStart,
}

/// The way counts go while the spindle angle rises.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum EncoderDirection {
    /// Counts rise.
    #[default]
    Rising,
    /// Counts fall.
    Falling,
}

impl EncoderDirection {
    pub(super) fn sign(self) -> i64 {
        match self {
            Self::Rising => 1,
            Self::Falling => -1,
        }
    }
}

/// An encoder on the spindle, whose count stands in every frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EncoderSettings {
    /// Counts of a turn, all edges of both tracks counted.
    pub counts_per_turn: u32,
    /// The way counts go while the spindle angle rises.
    #[serde(default)]
    pub direction: EncoderDirection,
    /// The instant at which the count of a frame was latched.
    #[serde(default)]
    pub latched_at: LatchedAt,
    /// From the trigger to the begin of the exposure, µs; for `frame_start` alone.
    #[serde(default)]
    pub frame_start_delay_us: f64,
    /// Spindle angle at the index pulse, or at count 0 where none is recorded, degrees.
    #[serde(default)]
    pub index_deg: f64,
    /// Counts by which an index pulse may depart from whole turns: one at either side, because it
    /// falls between two counts.
    #[serde(default = "one")]
    pub index_tolerance_counts: u32,
    /// Frames of a turn, equally spaced, where the encoder triggers them; a turn with another
    /// number is void.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames_per_turn: Option<u32>,
}

fn one() -> u32 {
    1
}

impl EncoderSettings {
    /// An encoder with these counts a turn and all defaults.
    pub fn new(counts_per_turn: u32) -> Self {
        Self {
            counts_per_turn,
            direction: EncoderDirection::Rising,
            latched_at: LatchedAt::ExposureStart,
            frame_start_delay_us: 0.0,
            index_deg: 0.0,
            index_tolerance_counts: one(),
            frames_per_turn: None,
        }
    }

    /// Checks the table.
    ///
    /// # Errors
    /// [`SettingError`] names the key.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        let counts = self.counts_per_turn;
        // 2^26 counts are the finest encoders of machine tools
        let right = "4 to 67108864 counts a turn";
        require((4..=1 << 26).contains(&counts), "scan.encoder.counts_per_turn", counts, right)?;
        let delay = self.frame_start_delay_us;
        let right = "a time of 0 to 1e6 us";
        require((0.0..=1e6).contains(&delay), "scan.encoder.frame_start_delay_us", delay, right)?;
        let is_needed = self.latched_at == LatchedAt::FrameStart || delay == 0.0;
        let right = "0 unless latched_at = \"frame_start\"";
        require(is_needed, "scan.encoder.frame_start_delay_us", delay, right)?;
        let zero = self.index_deg;
        require(zero.is_finite(), "scan.encoder.index_deg", zero, "an angle in degrees")?;
        let tolerance = self.index_tolerance_counts;
        let right = "less than an eighth of a turn";
        require(tolerance < counts.div_ceil(8), "scan.encoder.index_tolerance_counts", tolerance, right)?;
        let Some(frames) = self.frames_per_turn else { return Ok(()) };
        let right = "2 to counts_per_turn / 2 frames";
        require((2..=counts / 2).contains(&frames), "scan.encoder.frames_per_turn", frames, right)
    }

    /// Time from the latch to the middle of the exposure, ns.
    pub(super) fn to_middle_ns(self, exposure_us: f64) -> f64 {
        let half = 0.5e3 * exposure_us;
        match self.latched_at {
            LatchedAt::ExposureStart => half,
            LatchedAt::ExposureEnd => -half,
            LatchedAt::FrameStart => 1e3 * self.frame_start_delay_us + half,
        }
    }

    /// Counts in the sense of the spindle angle.
    pub(super) fn forward(&self, counts: i64) -> i64 {
        counts * self.direction.sign()
    }

    /// Spindle angle of a count since the index, degrees, 0 to below 360.
    pub(super) fn angle_deg(&self, counts: f64) -> f64 {
        (self.index_deg + 360.0 * counts / f64::from(self.counts_per_turn)).rem_euclid(360.0)
    }
}
