//! `[control.within_pass]`: correction of the stations ahead while a pass is cut.

use crate::setting::{SettingError, require};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a gauge that follows the tool may change of the pass it measures (`scan.when =
/// "during_cut"`).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WithinPassSettings {
    /// Share of the deviation found behind the tool that is taken off ahead of it, above 0 and at
    /// most 1.
    pub gain: f64,
    /// Largest change against the offsets planned, mm of diameter.
    pub limit_mm: f64,
}

impl Default for WithinPassSettings {
    fn default() -> Self {
        Self { gain: 0.7, limit_mm: 0.1 }
    }
}

impl WithinPassSettings {
    pub(super) fn validate(&self) -> Result<(), SettingError> {
        let (gain, limit) = (self.gain, self.limit_mm);
        require(gain > 0.0 && gain <= 1.0, "control.within_pass.gain", gain, "above 0 and at most 1")?;
        require(
            limit > 0.0 && limit.is_finite(),
            "control.within_pass.limit_mm",
            limit,
            "a positive length in mm",
        )
    }
}
