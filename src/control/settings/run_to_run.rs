//! `[control.ewma]`, `[control.dewma]`, `[control.ilc]` and `[control.parts]`.

use crate::setting::{SettingError, require};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Run-to-run controller with an exponentially weighted moving average: `[control.ewma]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EwmaSettings {
    /// Weight λ of the newest disturbance, 0 < λ ≤ 1.
    pub weight: f64,
    /// Plant gain b̂ the controller assumes, 0 < b̂ ≤ 2.
    pub gain_estimate: f64,
    /// Begin with the mean of what was seen (weight 1/k while that is larger than λ) instead of
    /// with zero.
    pub mean_start: bool,
}

impl Default for EwmaSettings {
    fn default() -> Self {
        Self { weight: 0.7, gain_estimate: 0.95, mean_start: true }
    }
}

/// Double EWMA: level and trend: `[control.dewma]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DoubleEwmaSettings {
    /// Weight λ₁ of the level, 0 < λ₁ ≤ 1.
    pub level_weight: f64,
    /// Weight λ₂ of the trend, 0 ≤ λ₂ ≤ 1.
    pub trend_weight: f64,
    /// Plant gain b̂ the controller assumes, 0 < b̂ ≤ 2.
    pub gain_estimate: f64,
    /// Begin with the first disturbance seen as level and no trend, instead of with zero.
    pub mean_start: bool,
}

impl Default for DoubleEwmaSettings {
    fn default() -> Self {
        Self { level_weight: 0.7, trend_weight: 0.3, gain_estimate: 0.95, mean_start: true }
    }
}

/// Iterative learning with a zero-phase filter along z: `[control.ilc]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct IlcSettings {
    /// Learning gain L, 0 < L < 2.
    pub learning_gain: f64,
    /// Wavelength along z at which the Q filter lets half the amplitude pass, mm; 0 for no filter
    /// (Q = 1).
    pub q_cutoff_mm: f64,
}

impl Default for IlcSettings {
    fn default() -> Self {
        Self { learning_gain: 1.05, q_cutoff_mm: 30.0 }
    }
}

/// Learning from part to part: `[control.parts]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PartsSettings {
    /// Carry offsets from part to part.
    pub enabled: bool,
    /// Weight of the newest part in the level of every station and pass, 0 < λ ≤ 1.
    pub level_weight: f64,
    /// Weight of the newest part in the trend, 0 ≤ λ ≤ 1.
    pub trend_weight: f64,
}

impl Default for PartsSettings {
    fn default() -> Self {
        Self { enabled: false, level_weight: 0.5, trend_weight: 0.3 }
    }
}

fn weight(key: &'static str, value: f64) -> Result<(), SettingError> {
    require(value > 0.0 && value <= 1.0, key, value, "a weight above 0 and at most 1")
}

fn gain(key: &'static str, value: f64) -> Result<(), SettingError> {
    require(value > 0.0 && value <= 2.0, key, value, "a gain above 0 and at most 2")
}

impl EwmaSettings {
    /// Checks the table.
    ///
    /// # Errors
    /// [`SettingError`] names the key.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        weight("control.ewma.weight", self.weight)?;
        gain("control.ewma.gain_estimate", self.gain_estimate)
    }
}

impl DoubleEwmaSettings {
    /// Checks the table.
    ///
    /// # Errors
    /// [`SettingError`] names the key.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        weight("control.dewma.level_weight", self.level_weight)?;
        let trend = self.trend_weight;
        require((0.0..=1.0).contains(&trend), "control.dewma.trend_weight", trend, "a weight of 0 to 1")?;
        gain("control.dewma.gain_estimate", self.gain_estimate)
    }
}

impl IlcSettings {
    /// Checks the table.
    ///
    /// # Errors
    /// [`SettingError`] names the key.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        let l = self.learning_gain;
        require(l > 0.0 && l < 2.0, "control.ilc.learning_gain", l, "a gain above 0 and below 2")?;
        let cutoff = self.q_cutoff_mm;
        let right = "a wavelength in mm, or 0 for no filter";
        require(cutoff >= 0.0 && cutoff.is_finite(), "control.ilc.q_cutoff_mm", cutoff, right)
    }
}

impl PartsSettings {
    /// Checks the table.
    ///
    /// # Errors
    /// [`SettingError`] names the key.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        weight("control.parts.level_weight", self.level_weight)?;
        let trend = self.trend_weight;
        require((0.0..=1.0).contains(&trend), "control.parts.trend_weight", trend, "a weight of 0 to 1")
    }
}
