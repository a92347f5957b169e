//! `[control.model]`: what the model-based controller believes before it has measured anything.

use super::require;
use crate::control::ControlError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Model-based controller: `[control.model]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ModelSettings {
    /// Force law believed: radial force F = C·a_p^x·f^y·v^z in N; C.
    pub coefficient_n: f64,
    /// Exponent of the depth of cut, 0 < x ≤ 2.
    pub depth_exponent: f64,
    /// Exponent of the feed.
    pub feed_exponent: f64,
    /// Exponent of the cutting speed.
    pub speed_exponent: f64,
    /// Young's modulus, N/mm².
    pub youngs_modulus_n_per_mm2: f64,
    /// Chuck face to tailstock, mm.
    pub length_mm: f64,
    /// Diameter of the stock, mm.
    pub stock_diameter_mm: f64,
    /// Radial stiffness of the chuck, N/µm.
    pub chuck_n_per_um: f64,
    /// Radial stiffness of the tailstock, N/µm.
    pub tailstock_n_per_um: f64,
    /// Standard uncertainty of ln C: .3 stands for about ± 30 %.
    pub u_ln_coefficient: f64,
    /// Standard uncertainty of the logarithm of both stiffnesses: .7 stands for about a factor of 2.
    pub u_ln_stiffness: f64,
    /// Standard uncertainty of the stock's mean diameter, mm.
    pub u_stock_mean_mm: f64,
    /// Standard deviation of the stock's diameter along z, mm.
    pub stock_form_mm: f64,
    /// Standard deviation of a constant or a taper of the machine, mm of radius.
    pub u_machine_mm: f64,
    /// Standard deviation of what a pass adds to it (wear, warming), mm of radius a pass.
    pub u_trend_mm: f64,
    /// Standard deviation of what the model cannot explain at a station and that stays, mm of radius.
    pub u_station_mm: f64,
    /// Standard deviation of its growth at a station, mm of radius a pass.
    pub u_station_trend_mm: f64,
    /// Standard deviation of what a pass adds all along the shaft and the next does not repeat, mm of radius.
    pub u_pass_mm: f64,
    /// Standard deviation of what comes and goes at a station from pass to pass, mm of radius.
    pub repeatability_mm: f64,
}

impl Default for ModelSettings {
    /// The force law is Table 1 of paper 003 (45 steel); the shaft is the preset's.
    fn default() -> Self {
        Self {
            coefficient_n: 4764.2,
            depth_exponent: 0.901,
            feed_exponent: 0.6,
            speed_exponent: -0.3,
            youngs_modulus_n_per_mm2: 2.1e5,
            length_mm: 500.0,
            stock_diameter_mm: 27.0,
            chuck_n_per_um: 50.0,
            tailstock_n_per_um: 20.0,
            u_ln_coefficient: 0.3,
            u_ln_stiffness: 0.7,
            u_stock_mean_mm: 0.05,
            stock_form_mm: 0.05,
            u_machine_mm: 0.001,
            u_trend_mm: 0.004,
            u_station_mm: 0.0005,
            u_station_trend_mm: 0.0001,
            u_pass_mm: 0.0003,
            repeatability_mm: 0.0003,
        }
    }
}

impl ModelSettings {
    /// Checks the table.
    ///
    /// # Errors
    /// [`ControlError::Setting`] names the key.
    pub fn validate(&self) -> Result<(), ControlError> {
        let positive = [
            ("control.model.coefficient_n", self.coefficient_n),
            ("control.model.depth_exponent", self.depth_exponent),
            ("control.model.youngs_modulus_n_per_mm2", self.youngs_modulus_n_per_mm2),
            ("control.model.length_mm", self.length_mm),
            ("control.model.stock_diameter_mm", self.stock_diameter_mm),
            ("control.model.chuck_n_per_um", self.chuck_n_per_um),
            ("control.model.tailstock_n_per_um", self.tailstock_n_per_um),
            ("control.model.u_ln_coefficient", self.u_ln_coefficient),
            ("control.model.u_ln_stiffness", self.u_ln_stiffness),
            ("control.model.u_stock_mean_mm", self.u_stock_mean_mm),
            ("control.model.stock_form_mm", self.stock_form_mm),
            ("control.model.u_machine_mm", self.u_machine_mm),
            ("control.model.u_trend_mm", self.u_trend_mm),
            ("control.model.u_station_mm", self.u_station_mm),
            ("control.model.u_station_trend_mm", self.u_station_trend_mm),
            ("control.model.u_pass_mm", self.u_pass_mm),
            ("control.model.repeatability_mm", self.repeatability_mm),
        ];
        for (key, value) in positive {
            require(value > 0.0 && !value.is_nan(), key, value, "a positive number")?;
        }
        for (key, value) in [
            ("control.model.feed_exponent", self.feed_exponent),
            ("control.model.speed_exponent", self.speed_exponent),
        ] {
            require(value.is_finite(), key, value, "a finite exponent")?;
        }
        let x = self.depth_exponent;
        require(x <= 2.0, "control.model.depth_exponent", x, "an exponent above 0 and at most 2")
    }
}
