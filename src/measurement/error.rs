//! Why there is no measurement.

use thiserror::Error;

use crate::conformity::JudgementError;
use crate::gauge::calibration::BenchError;
use crate::gauge::diameter::reading_series::StatisticsError;
use crate::gauge::form::FormError;
use crate::gauge::ring::RingError;
use crate::gauge::{CalibrationError, FrameRefused};
use crate::profile::Reason;
use crate::setting::SettingError;

/// Why a frame, a series or a setting gives no measurement.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MeasureError {
    /// A setting out of its range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// Limits or a probability that cannot judge.
    #[error(transparent)]
    Judgement(#[from] JudgementError),
    /// An average that cannot be formed.
    #[error(transparent)]
    Average(#[from] StatisticsError),
    /// A filter out of range.
    #[error(transparent)]
    Cutoff(#[from] FormError),
    /// A calibration that does not hold for the gauge's edge-spread function.
    #[error(transparent)]
    EdgeModel(CalibrationError),
    /// A size over the revolution, without one.
    #[error("{criterion} is judged over the length and all around: give the frames of a turn and --turn")]
    NeedsTurn {
        /// The criterion of the tolerance.
        criterion: &'static str,
    },
    /// Averages of whole frames and parts of each.
    #[error(
        "--average averages the mean of whole frames and --station-mm gives parts of each: one of them at a time"
    )]
    AverageOfStations,
    /// A setting in millimetres, without a scale.
    #[error("{setting} needs millimetres: give a calibration or a scale")]
    NeedsScale {
        /// The setting.
        setting: &'static str,
    },
    /// A frame that shows no part with two edges.
    #[error("frame {frame}: {source}")]
    Refused {
        /// Name of the frame.
        frame: String,
        /// What was seen and what would be right.
        source: FrameRefused,
    },
    /// A frame whose blur differs from the masters', because its edges are displaced.
    #[error("frame {frame}: {source}")]
    Blurred {
        /// Name of the frame.
        frame: String,
        /// The blur found and that of the masters.
        source: BenchError,
    },
    /// A frame of another size than the calibration's.
    #[error("frame {frame}: {source}")]
    OtherSize {
        /// Name of the frame.
        frame: String,
        /// Both sizes.
        source: BenchError,
    },
    /// A frame whose file encoded light otherwise than the calibration's frames.
    #[error("frame {frame}: {source}")]
    OtherEncoding {
        /// Name of the frame.
        frame: String,
        /// Both encodings.
        source: CalibrationError,
    },
    /// A frame whose reference pin corrects nothing.
    #[error("frame {frame}: the reference pin: {why}")]
    ReferencePin {
        /// Name of the frame.
        frame: String,
        /// What was seen of the pin and what would be right.
        why: String,
    },
    /// A frame outside the range in which the machine that carries the head was identified.
    #[error(
        "frame {frame}: its field at z = {z_mm:.3} mm lies outside {from_mm:.3} to {to_mm:.3} mm, where the machine was identified; beyond it \
         nothing is known of the head's place"
    )]
    BeyondMachine {
        /// Name of the frame.
        frame: String,
        /// Where it is, mm.
        z_mm: f64,
        /// From where the machine is known, mm.
        from_mm: f64,
        /// To where, mm.
        to_mm: f64,
    },
    /// A frame whose largest diameter, or its u, is no number.
    #[error("frame {frame}: its diameter or uncertainty is no number: it has no diameter")]
    NoNumber {
        /// Name of the frame.
        frame: String,
    },
    /// No frame of a turn has a diameter.
    #[error("no frame of the turn could be measured")]
    NoFrameOfTurn,
    /// Frames that do not form a turn.
    #[error("the frames make no turn at z = {z_mm:.3} mm: {why}")]
    NoTurn {
        /// Middle of the first section, mm.
        z_mm: f64,
        /// What the section lacks.
        why: String,
    },
    /// A frame without a ring.
    #[error(transparent)]
    Ring(#[from] RingError),
}

impl MeasureError {
    /// Whether what was asked is at fault, not a frame.
    pub fn is_of_settings(&self) -> bool {
        matches!(
            self,
            Self::Setting(_)
                | Self::Judgement(_)
                | Self::Average(_)
                | Self::Cutoff(_)
                | Self::EdgeModel(_)
                | Self::NeedsTurn { .. }
                | Self::AverageOfStations
                | Self::NeedsScale { .. }
        )
    }

    /// The reason that a frame's columns have.
    pub(super) fn reason(&self) -> Reason {
        match self {
            Self::Refused { source, .. } => source.reason,
            Self::Blurred { .. } => Reason::Blurred,
            Self::NoNumber { .. } | Self::ReferencePin { .. } => Reason::Implausible,
            _ => Reason::Unreadable,
        }
    }
}
