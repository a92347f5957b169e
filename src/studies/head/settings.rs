//! What is asked of every head.

use crate::gauge::calibration::{Date, GivenConditions};

/// Limits of motion during an exposure.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExposureLimits {
    /// Undulations per revolution that are to be resolved.
    pub(crate) undulations_upr: f64,
    /// Loss of their amplitude that is accepted, 0 to 1.
    pub(crate) amplitude_loss: f64,
    /// Blur by run-out over the standard uncertainty of the diameter.
    pub(crate) share_of_u: f64,
}

/// What is asked of every head.
#[derive(Clone, Debug)]
pub(crate) struct HeadSettings {
    /// Diameter of the part, mm; the config's where it is none.
    pub(crate) diameter_mm: Option<f64>,
    /// Speed in use, rev/min; the config's where it is none.
    pub(crate) rpm: Option<f64>,
    /// Eccentricity, mm; the config's where it is none.
    pub(crate) eccentricity_mm: Option<f64>,
    /// Conditions of the part.
    pub(crate) conditions: Option<GivenConditions>,
    /// By how much a diameter may move in the depth of field, µm; U/4 where it is none.
    pub(crate) depth_limit_um: Option<f64>,
    /// Limits of the exposure.
    pub(crate) exposure: ExposureLimits,
    /// Frames that are rendered and measured.
    pub(crate) frames: usize,
    /// Seed of their noise.
    pub(crate) seed: u64,
    /// Day of the calibrations.
    pub(crate) date: Date,
}

impl HeadSettings {
    /// A head before a part at rest, of a diameter or the config's; nothing is rendered.
    pub(crate) fn plain(diameter_mm: Option<f64>, date: Date) -> Self {
        Self {
            diameter_mm,
            rpm: Some(0.0),
            eccentricity_mm: Some(0.0),
            conditions: None,
            depth_limit_um: None,
            // As the arguments of `study head` have them.
            exposure: ExposureLimits { undulations_upr: 15.0, amplitude_loss: 0.01, share_of_u: 0.3 },
            frames: 0,
            seed: 1,
            date,
        }
    }
}
