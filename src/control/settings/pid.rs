//! `[control.pid]`.

use crate::control::error::require_limit;
use crate::control::shapes::Shapes;
use crate::setting::{SettingError, require};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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
    /// The output changes by at most this a pass, mm of diameter; the sum stops there
    /// (anti-windup).
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

impl PidSettings {
    /// Checks the table.
    ///
    /// # Errors
    /// [`SettingError`] names the key.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
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
            Spatial::Modal(shapes) => shapes.validate("control.pid.spatial.modal"),
        }
    }
}
