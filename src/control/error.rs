//! Errors of the control stage.

use super::controller_name::ControllerName;
use crate::setting::{SettingError, require};

/// Why a controller cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ControlError {
    /// A value of the `[control]` table is out of its range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// No controller has this name.
    #[error("no controller is called {word:?}; there are {}", names())]
    UnknownController {
        /// The word given.
        word: String,
    },
    /// The closed loop is unstable at the assumed plant gain.
    #[error(
        "the {controller} loop is unstable at control.plant_gain = {plant_gain} (stable for {range}; spectral radius \
         {spectral_radius:.4}): lower the gains, or set control.insist_on_unstable = true"
    )]
    Unstable {
        /// Controller and form.
        controller: String,
        /// The gain assumed.
        plant_gain: f64,
        /// Gains for which the loop is stable, as text.
        range: String,
        /// Largest pole modulus.
        spectral_radius: f64,
    },
    /// There are too few stations for the configured shapes.
    #[error(
        "{stations} stations cannot carry {shapes} shape functions along z: take fewer shapes or shorter stations"
    )]
    TooFewStations {
        /// Stations of the job.
        stations: usize,
        /// Configured shapes.
        shapes: usize,
    },
    /// Stations must ascend.
    #[error("station {index} at z = {z_mm} mm does not ascend")]
    StationOrder {
        /// First station that does not lie beyond its predecessor.
        index: usize,
        /// Its z, mm.
        z_mm: f64,
    },
}

fn names() -> String {
    ControllerName::ALL.map(ControllerName::as_str).join(", ")
}

impl std::str::FromStr for ControllerName {
    type Err = ControlError;

    fn from_str(word: &str) -> Result<Self, ControlError> {
        Self::ALL
            .into_iter()
            .find(|name| name.as_str() == word)
            .ok_or_else(|| ControlError::UnknownController { word: word.to_owned() })
    }
}

/// Refuses a limit that is given and not positive.
pub(super) fn require_limit(key: &'static str, limit: Option<f64>) -> Result<(), SettingError> {
    limit.map_or(Ok(()), |value| {
        require(value > 0.0 && value.is_finite(), key, value, "a positive length in mm")
    })
}
