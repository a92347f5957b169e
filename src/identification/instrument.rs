//! What readings were taken with, and what each kind of reading holds of a machine.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::machine::error_name::{Axis, Component, ErrorName};

/// What took the readings of a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Instrument {
    /// A laser interferometer: positioning, straightness, pitch and yaw.
    Laser,
    /// A level: angles about horizontal axes.
    Level,
    /// An autocollimator: pitch and yaw.
    Autocollimator,
    /// A straightedge, read as it lies and reversed.
    Straightedge,
    /// A cylinder turned on the machine: radius over z.
    Cylinder,
    /// A face turned on the machine: height over the radius.
    Face,
    /// The midline of a two-sided head over z, mean of φ and φ + 180°.
    Midline,
}

/// What a reading is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    /// An error by its name.
    Error(ErrorName),
    /// Deviation of a turned cylinder's radius.
    Radius,
    /// Deviation of a turned face's height, growing with z.
    Height,
    /// Height of the midline in the head's image.
    Midline,
    /// Slope of the midline.
    Slope,
}

impl Quantity {
    /// By the word in the column `error`.
    pub(crate) fn parse(word: &str) -> Option<Self> {
        match word.to_ascii_lowercase().as_str() {
            "radius" => Some(Self::Radius),
            "height" => Some(Self::Height),
            "midline" => Some(Self::Midline),
            "slope" => Some(Self::Slope),
            name => ErrorName::ALL
                .into_iter()
                .find(|error| error.code().eq_ignore_ascii_case(name))
                .map(Self::Error),
        }
    }

    /// The word.
    pub(crate) fn word(self) -> String {
        match self {
            Self::Error(name) => name.code(),
            Self::Radius => "radius".to_owned(),
            Self::Height => "height".to_owned(),
            Self::Midline => "midline".to_owned(),
            Self::Slope => "slope".to_owned(),
        }
    }

    /// Whether it is a length; else an angle.
    pub(crate) fn is_length(self) -> bool {
        match self {
            Self::Error(name) => name.is_length(),
            other => other != Self::Slope,
        }
    }

    /// The slide over whose position it is read.
    pub(crate) fn axis(self) -> Axis {
        match self {
            Self::Error(name) => name.axis(),
            Self::Height => Axis::X,
            Self::Radius | Self::Midline | Self::Slope => Axis::Z,
        }
    }
}

impl Instrument {
    /// The name in a config.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Laser => "laser",
            Self::Level => "level",
            Self::Autocollimator => "autocollimator",
            Self::Straightedge => "straightedge",
            Self::Cylinder => "cylinder",
            Self::Face => "face",
            Self::Midline => "midline",
        }
    }

    /// What a set of it reads, for refusals.
    pub(crate) fn reads(self) -> &'static str {
        match self {
            Self::Laser => "positioning, straightness, pitch or yaw of X or Z (no roll)",
            Self::Level => "an angle of X or Z",
            Self::Autocollimator => "pitch or yaw of X or Z (it does not see roll about its own beam)",
            Self::Straightedge => "a straightness of X or Z",
            Self::Cylinder => "radius",
            Self::Face => "height",
            Self::Midline => "midline or slope",
        }
    }

    /// Whether it can read a quantity.
    pub(crate) fn can_read(self, quantity: Quantity) -> bool {
        let Quantity::Error(name) = quantity else {
            return match self {
                Self::Cylinder => quantity == Quantity::Radius,
                Self::Face => quantity == Quantity::Height,
                Self::Midline => matches!(quantity, Quantity::Midline | Quantity::Slope),
                _ => false,
            };
        };
        if name.axis() == Axis::C {
            return false;
        }
        let own = if name.axis() == Axis::X { 0 } else { 2 };
        match (self, name.component()) {
            (Self::Laser, Component::Along(_)) | (Self::Level, Component::About(_)) => true,
            (Self::Laser | Self::Autocollimator, Component::About(k)) => k != own,
            (Self::Straightedge, Component::Along(k)) => k != own,
            _ => false,
        }
    }

    /// Whether its readings are of a part that the machine turned.
    pub(crate) fn is_part(self) -> bool {
        matches!(self, Self::Cylinder | Self::Face)
    }
}

/// Whether an error is a straightness: its offset and slope are those of its reference line (ISO
/// 230-1), the slope is an orientation.
pub(crate) fn is_straightness(name: ErrorName) -> bool {
    let own = if name.axis() == Axis::X { 0 } else { 2 };
    matches!(name.component(), Component::Along(k) if k != own)
}
