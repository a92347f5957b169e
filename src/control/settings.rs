//! The `[control]` table of a configuration.

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
}

impl ControllerName {
    /// Every controller, in the order in which comparisons list them.
    pub const ALL: [Self; 3] = [Self::None, Self::Pid, Self::Lsq];

    /// The word used on the command line and in files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Pid => "pid",
            Self::Lsq => "lsq",
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
    /// Limits that an offset must pass before it is released.
    pub guards: GuardSettings,
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
            guards: GuardSettings::default(),
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

/// How the controller output becomes the offset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OffsetForm {
    /// o(k+1) = u(k), as printed in paper 003, eq. 18.
    Absolute,
    /// o(k+1) = o(k) + u(k): the output corrects what is in force.
    #[default]
    Accumulated,
}

/// Which algorithm computes the output; both give the same numbers while nothing is limited.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PidAlgorithm {
    /// Eq. 16: proportional, sum and difference of the errors.
    #[default]
    Positional,
    /// Eq. 17: the change of the output.
    Incremental,
}

/// What acts on the first pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FirstPass {
    /// Proportional and integral part (the difference is zero): u(1) = (Kp + Ki) e(1).
    #[default]
    Full,
    /// Eq. 18's second line: u(1) = Kp e(1).
    Proportional,
}

/// PID controller: `[control.pid]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PidSettings {
    /// Proportional gain Kp, ≥ 0.
    pub kp: f64,
    /// Integral gain Ki per pass, ≥ 0.
    pub ki: f64,
    /// Derivative gain Kd in passes, ≥ 0.
    pub kd: f64,
    /// Absolute or accumulated offsets.
    pub form: OffsetForm,
    /// Positional or incremental.
    pub algorithm: PidAlgorithm,
    /// Whether the integral acts on the first pass.
    pub first_pass: FirstPass,
    /// Share of the last filtered difference in the next one, 0 (no filter) ≤ α < 1.
    pub derivative_filter: f64,
    /// Errors smaller than this count as zero, mm of diameter.
    pub deadband_mm: f64,
    /// The output u stays within ± this, mm of diameter; the sum stops there (anti-windup).
    pub output_limit_mm: Option<f64>,
    /// The output changes by at most this a pass, mm of diameter; the sum stops there (anti-windup).
    pub rate_limit_mm: Option<f64>,
    /// Per station or a few shapes along z.
    pub spatial: Spatial,
}

impl Default for PidSettings {
    /// Gains of paper 003, section 3.3.
    fn default() -> Self {
        Self {
            kp: 1.2,
            ki: 0.05,
            kd: 0.05,
            form: OffsetForm::default(),
            algorithm: PidAlgorithm::default(),
            first_pass: FirstPass::default(),
            derivative_filter: 0.0,
            deadband_mm: 0.0,
            output_limit_mm: None,
            rate_limit_mm: None,
            spatial: Spatial::default(),
        }
    }
}

/// What a controller acts on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Spatial {
    /// One loop a station.
    #[default]
    Station,
    /// One loop a shape: the error is fitted by these shapes and only they are corrected.
    Modal(Shapes),
}

/// Shape functions along z.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Shapes {
    /// Paper 000, eq. 4: ε = b·x + a.
    #[default]
    Line,
    /// Parabola.
    Quadratic,
    /// Polynomial of this degree, 0-8.
    Polynomial {
        /// Highest power.
        degree: usize,
    },
}

/// Least-squares controller: `[control.lsq]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LsqSettings {
    /// The shape that is fitted and compensated.
    pub shapes: Shapes,
    /// Weigh stations by their measured standard uncertainty, or all alike.
    pub weighted: bool,
    /// Share of the fitted error that is compensated, 0 < gain < 2.
    pub gain: f64,
}

impl Default for LsqSettings {
    fn default() -> Self {
        Self { shapes: Shapes::default(), weighted: true, gain: 1.0 }
    }
}

/// Limits of what is released: `[control.guards]`. At a refusal the last offsets hold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GuardSettings {
    /// Largest change of an offset at any station, mm of diameter. The first correction of a slender shaft takes 60 µm.
    pub step_limit_mm: f64,
    /// Largest offset at any station, mm of diameter.
    pub cumulative_limit_mm: f64,
    /// Largest |D - r| that is believed, mm.
    pub plausible_error_mm: f64,
    /// Largest combined standard uncertainty of a station that is acted on, mm.
    pub uncertainty_limit_mm: f64,
}

impl Default for GuardSettings {
    fn default() -> Self {
        Self {
            step_limit_mm: 0.1,
            cumulative_limit_mm: 0.3,
            plausible_error_mm: 0.5,
            uncertainty_limit_mm: 0.005,
        }
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
        self.guards.validate()
    }
}

impl PidSettings {
    /// Checks the table.
    ///
    /// # Errors
    /// [`ControlError::Setting`] names the key.
    pub fn validate(&self) -> Result<(), ControlError> {
        let gains = [("control.pid.kp", self.kp), ("control.pid.ki", self.ki), ("control.pid.kd", self.kd)];
        for (key, gain) in gains {
            require(gain >= 0.0 && gain.is_finite(), key, gain, "a gain of 0 or more")?;
        }
        let alpha = self.derivative_filter;
        require(
            (0.0..1.0).contains(&alpha),
            "control.pid.derivative_filter",
            alpha,
            "0 (no filter) or more, below 1",
        )?;
        let band = self.deadband_mm;
        require(
            band >= 0.0 && band.is_finite(),
            "control.pid.deadband_mm",
            band,
            "a length of 0 mm or more",
        )?;
        require_limit("control.pid.output_limit_mm", self.output_limit_mm)?;
        require_limit("control.pid.rate_limit_mm", self.rate_limit_mm)?;
        match self.spatial {
            Spatial::Station => Ok(()),
            Spatial::Modal(shapes) => shapes.validate("control.pid.spatial.modal.polynomial.degree"),
        }
    }
}

impl Shapes {
    fn validate(self, key: &'static str) -> Result<(), ControlError> {
        match self {
            Self::Line | Self::Quadratic => Ok(()),
            Self::Polynomial { degree } => require(degree <= 8, key, degree as f64, "a degree of 0 to 8"),
        }
    }
}

impl LsqSettings {
    /// Checks the table.
    ///
    /// # Errors
    /// [`ControlError::Setting`] names the key.
    pub fn validate(&self) -> Result<(), ControlError> {
        self.shapes.validate("control.lsq.shapes.polynomial.degree")?;
        require(
            self.gain > 0.0 && self.gain < 2.0,
            "control.lsq.gain",
            self.gain,
            "a share above 0 and below 2",
        )
    }
}

impl GuardSettings {
    /// Checks the table.
    ///
    /// # Errors
    /// [`ControlError::Setting`] names the key.
    pub fn validate(&self) -> Result<(), ControlError> {
        let limits = [
            ("control.guards.step_limit_mm", self.step_limit_mm),
            ("control.guards.cumulative_limit_mm", self.cumulative_limit_mm),
            ("control.guards.plausible_error_mm", self.plausible_error_mm),
            ("control.guards.uncertainty_limit_mm", self.uncertainty_limit_mm),
        ];
        for (key, limit) in limits {
            require_limit(key, Some(limit))?;
        }
        Ok(())
    }
}
