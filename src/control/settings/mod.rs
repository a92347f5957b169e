//! The `[control]` table of a configuration.

mod guards;
mod lsq;
mod model;
mod pid;
mod run_to_run;
mod within_pass;

pub use guards::{GuardSettings, OnAlarm};
pub use lsq::{ApplyTo, Estimator, LsqSettings};
pub use model::{ModelSettings, Workpiece};
pub use pid::{FirstPass, OffsetForm, PidAlgorithm, PidSettings, Spatial};
pub use run_to_run::{DoubleEwmaSettings, EwmaSettings, IlcSettings, PartsSettings};
pub use within_pass::WithinPassSettings;

use super::ControlError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which controller decides the offsets of the next pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ControllerName {
    /// No correction: the offsets stay zero.
    None,
    /// Proportional-integral-derivative, `[control.pid]`.
    #[default]
    Pid,
    /// Least-squares shape, `[control.lsq]`.
    Lsq,
    /// Run-to-run EWMA per station, `[control.ewma]`.
    Ewma,
    /// Double EWMA with trend per station, `[control.dewma]`.
    Dewma,
    /// Iterative learning with a Q filter along z, `[control.ilc]`.
    Ilc,
    /// Model-based, `[control.model]`.
    Model,
}

impl ControllerName {
    /// Every controller, in the order in which comparisons list them.
    pub const ALL: [Self; 7] =
        [Self::None, Self::Pid, Self::Lsq, Self::Ewma, Self::Dewma, Self::Ilc, Self::Model];

    /// The word used on the command line and in files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Pid => "pid",
            Self::Lsq => "lsq",
            Self::Ewma => "ewma",
            Self::Dewma => "dewma",
            Self::Ilc => "ilc",
            Self::Model => "model",
        }
    }
}

impl std::fmt::Display for ControllerName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.as_str())
    }
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

/// Pass-to-pass compensation: `[control]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ControlSettings {
    /// The controller in use.
    pub controller: ControllerName,
    /// Build a controller although its closed loop is unstable at `plant_gain`.
    pub insist_on_unstable: bool,
    /// Plant gain g for which stability is judged: change of diameter over change of command, 0 < g ≤ 2. A slender
    /// shaft between chuck and tailstock has .9-1 (1 would be a rigid one).
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
    /// Correction within the pass by a gauge that follows the tool; none leaves a pass as it was planned.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub within_pass: Option<WithinPassSettings>,
}

impl Default for ControlSettings {
    fn default() -> Self {
        Self {
            controller: ControllerName::default(),
            insist_on_unstable: false,
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
    /// Longest run of neighbouring stations that may be interpolated linearly between measured ones (0: none). Ends
    /// are never extrapolated.
    pub interpolate_run: usize,
    /// Most stations that may be interpolated in all, as a share of the stations, 0-1.
    pub interpolate_share: f64,
}

impl Default for GapSettings {
    fn default() -> Self {
        Self { interpolate_run: 0, interpolate_share: 0.1 }
    }
}

/// Refuses a value, naming its key and what would be right.
pub(crate) fn require(
    holds: bool,
    key: &'static str,
    value: f64,
    right: &'static str,
) -> Result<(), ControlError> {
    if holds { Ok(()) } else { Err(ControlError::Setting { key, value, right }) }
}

/// Refuses a limit that is given and not positive.
fn require_limit(key: &'static str, limit: Option<f64>) -> Result<(), ControlError> {
    limit.map_or(Ok(()), |value| {
        require(value > 0.0 && value.is_finite(), key, value, "a positive length in mm")
    })
}

impl ControlSettings {
    /// Checks every value of the table.
    ///
    /// # Errors
    /// [`ControlError::Setting`] names the key, its value and what would be right.
    pub fn validate(&self) -> Result<(), ControlError> {
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
