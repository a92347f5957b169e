//! The state of a machine at which its errors are evaluated.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::setting::{SettingError, within};

/// Temperature at which drift is zero, °C (ISO 1).
pub(crate) const REFERENCE_C: f64 = 20.0;

/// From which side a position was approached.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Direction {
    /// The position grew.
    #[default]
    Forward,
    /// The position fell.
    Backward,
}

/// The state of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Conditions {
    /// Direction in which the X slide reached its position.
    pub x_direction: Direction,
    /// Direction in which the Z slide reached its position.
    pub z_direction: Direction,
    /// Spindle angle, degrees.
    pub c_deg: f64,
    /// Temperature of the machine, °C; 20 is the reference. Must lie between -20 and 80.
    pub temperature_c: f64,
    /// Time since the spindle and the slides started from cold, minutes. Must be at least 0.
    pub minutes: f64,
}

impl Default for Conditions {
    fn default() -> Self {
        Self {
            x_direction: Direction::Forward,
            z_direction: Direction::Forward,
            c_deg: 0.0,
            temperature_c: REFERENCE_C,
            minutes: 0.0,
        }
    }
}

impl Conditions {
    /// Checks the values.
    ///
    /// # Errors
    /// The first value out of range.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        within("conditions.c_deg", self.c_deg, -3600.0, 3600.0, "an angle in degrees")?;
        let right = "between -20 and 80 °C";
        within("conditions.temperature_c", self.temperature_c, -20.0, 80.0, right)?;
        within("conditions.minutes", self.minutes, 0.0, 1e5, "at least 0 and at most 100000 minutes")
    }
}
