//! What is asked of the models, checked.

use crate::setting::{SettingError, require, within};

/// What is asked of the models.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ModelsAsked {
    /// Standard deviation of a sample, µm.
    pub noise_um: f64,
    /// Positions of either slide.
    pub positions: usize,
    /// Hidden units of the net of two inputs.
    pub hidden: usize,
    /// Seed of the noise and of the starts.
    pub seed: u64,
    /// Whether nets are fitted: nearly all of the time goes into them.
    pub nets: bool,
}

impl Default for ModelsAsked {
    /// The paper's raster and probe; 20 units hold what its table holds.
    fn default() -> Self {
        Self { noise_um: 0.01, positions: 51, hidden: 20, seed: 1, nets: true }
    }
}

impl ModelsAsked {
    /// Checks the ranges.
    ///
    /// # Errors
    /// The first value out of range, by its option of the command line.
    pub(super) fn check(&self) -> Result<(), SettingError> {
        within("--noise-um", self.noise_um, 0.0, 100.0, "between 0 and 100 µm")?;
        require((8..=201).contains(&self.positions), "--positions", self.positions, "between 8 and 201")?;
        require((1..=60).contains(&self.hidden), "--hidden", self.hidden, "between 1 and 60")
    }
}
