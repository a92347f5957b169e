//! A checked machine with the positions of its map.

use super::config::MachineStudyConfig;
use crate::machine::{Conditions, MachineSettings, Motion};
use crate::setting::SettingError;

/// A machine, its errors as functions, its state and the positions of its map.
pub(crate) struct Prepared {
    /// The chain and its levers.
    pub settings: MachineSettings,
    /// The errors.
    pub motion: Motion,
    /// The state.
    pub state: Conditions,
    /// Positions of X, mm.
    pub x_mm: Vec<f64>,
    /// Positions of Z, mm.
    pub z_mm: Vec<f64>,
}

impl Prepared {
    /// Checks a config.
    ///
    /// # Errors
    /// The first value that cannot be right.
    pub(crate) fn of(config: &MachineStudyConfig) -> Result<Self, SettingError> {
        let motion = config.machine.motion()?;
        config.validate()?;
        Ok(Self {
            settings: config.machine.clone(),
            motion,
            state: config.conditions,
            x_mm: spaced(config.machine.x_travel_mm, config.map.x_points),
            z_mm: spaced(config.machine.z_travel_mm, config.map.z_points),
        })
    }
}

/// Equally spaced positions, both ends included.
fn spaced([from, to]: [f64; 2], count: usize) -> Vec<f64> {
    let step = (to - from) / (count - 1) as f64;
    (0..count).map(|k| if k + 1 == count { to } else { from + step * k as f64 }).collect()
}
