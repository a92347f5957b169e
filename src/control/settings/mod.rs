//! The `[control]` table of a configuration.

mod guards;
mod lsq;
mod model;
mod pid;
mod run_to_run;
mod within_pass;

pub use self::{
    guards::{GuardSettings, OnAlarm},
    lsq::{ApplyTo, Estimator, LsqSettings},
    model::{ModelSettings, Workpiece},
    pid::{FirstPass, OffsetForm, PidAlgorithm, PidSettings, Spatial},
    run_to_run::{DoubleEwmaSettings, EwmaSettings, IlcSettings, PartsSettings},
    within_pass::WithinPassSettings,
};

use super::controller_name::ControllerName;
use crate::setting::{SettingError, require};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Pass-to-pass compensation: `[control]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ControlSettings {
    /// The controller in use.
    pub controller: ControllerName,
    /// Build a controller although its closed loop is unstable at `plant_gain`.
    #[serde(rename = "insist_on_unstable")]
    pub allow_unstable: bool,
    /// Plant gain g for which stability is judged: change of diameter over change of command, 0 < g
    /// ≤ 2. A slender shaft between chuck and tailstock has .9-1 (1 would be a rigid one).
    pub plant_gain: f64,
    /// What to do where stations have no reading.
    pub gaps: GapSettings,
    /// The PID controller.
    pub pid: PidSettings,
    /// The least-squares controller.
    pub lsq: LsqSettings,
    /// The run-to-run controller.
    pub ewma: EwmaSettings,
    /// The run-to-run controller with trend.
    pub dewma: DoubleEwmaSettings,
    /// The iterative-learning controller.
    pub ilc: IlcSettings,
    /// The model-based controller.
    pub model: ModelSettings,
    /// Learning from part to part.
    pub parts: PartsSettings,
    /// Limits that an offset must pass before it is released.
    pub guards: GuardSettings,
    /// Correction within the pass by a gauge that follows the tool; none leaves a pass as it was
    /// planned.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub within_pass: Option<WithinPassSettings>,
}

impl Default for ControlSettings {
    fn default() -> Self {
        Self {
            controller: ControllerName::default(),
            allow_unstable: false,
            plant_gain: 0.95,
            gaps: GapSettings::default(),
            pid: PidSettings::default(),
            lsq: LsqSettings::default(),
            ewma: EwmaSettings::default(),
            dewma: DoubleEwmaSettings::default(),
            ilc: IlcSettings::default(),
            model: ModelSettings::default(),
            parts: PartsSettings::default(),
            guards: GuardSettings::default(),
            within_pass: None,
        }
    }
}

/// Stations without a reading: `[control.gaps]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GapSettings {
    /// Longest run of neighbouring stations that may be interpolated linearly between measured ones
    /// (0: none). Ends are never extrapolated.
    pub interpolate_run: usize,
    /// Most stations that may be interpolated in all, as a share of the stations, 0-1.
    pub interpolate_share: f64,
}

impl Default for GapSettings {
    fn default() -> Self {
        Self { interpolate_run: 0, interpolate_share: 0.1 }
    }
}

impl ControlSettings {
    /// Checks every value of the table.
    ///
    /// # Errors
    /// [`SettingError`] names the key, its value and what would be right.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        let g = self.plant_gain;
        require(g > 0.0 && g <= 2.0, "control.plant_gain", g, "a gain above 0 and at most 2")?;
        let share = self.gaps.interpolate_share;
        require((0.0..=1.0).contains(&share), "control.gaps.interpolate_share", share, "a share of 0 to 1")?;
        self.pid.validate()?;
        self.lsq.validate()?;
        self.ewma.validate()?;
        self.dewma.validate()?;
        self.ilc.validate()?;
        self.model.validate()?;
        self.parts.validate()?;
        self.within_pass.map_or(Ok(()), |w| w.validate())?;
        self.guards.validate()
    }
}
