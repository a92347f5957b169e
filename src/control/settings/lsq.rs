//! `[control.lsq]`.

use crate::control::shapes::Shapes;
use crate::setting::{SettingError, require};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the shapes are fitted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Estimator {
    /// Least squares (eqs 5-6 where unweighted).
    #[default]
    LeastSquares,
    /// Huber's M-estimator: stations far off the shape lose weight.
    Huber,
}

/// Which passes are compensated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ApplyTo {
    /// Every pass that follows a measured one.
    #[default]
    EveryPass,
    /// Only the finishing pass, as in paper 000: what was measured after semi-finishing is
    /// compensated once.
    FinishingPass,
}

/// Least-squares controller: `[control.lsq]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LsqSettings {
    /// The shape that is fitted and compensated.
    pub shapes: Shapes,
    /// Weigh stations by their measured standard uncertainty, or all alike.
    pub weighted: bool,
    /// Plain or robust.
    pub estimator: Estimator,
    /// Which passes are compensated.
    pub apply_to: ApplyTo,
    /// Share of the fitted error that is compensated, 0 < gain < 2.
    pub gain: f64,
}

impl Default for LsqSettings {
    fn default() -> Self {
        Self {
            shapes: Shapes::default(),
            weighted: true,
            estimator: Estimator::default(),
            apply_to: ApplyTo::default(),
            gain: 1.0,
        }
    }
}

impl LsqSettings {
    /// Checks the table.
    ///
    /// # Errors
    /// [`SettingError`] names the key.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        self.shapes.validate("control.lsq.shapes")?;
        require(
            self.gain > 0.0 && self.gain < 2.0,
            "control.lsq.gain",
            self.gain,
            "a share above 0 and below 2",
        )
    }
}
