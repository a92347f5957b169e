//! `[control.model]`: what the model-based controller assumes before it has measured anything.
//!
//! Length, diameter, material, supports and force law describe the job's own part and follow from
//! it where the table leaves them out ([`Workpiece`]); a controller that is built without a job
//! falls back on the slender-shaft paper's part.

use crate::setting::{SettingError, require};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the model-based controller takes from the job: the part, how it is held and its expected
/// cutting force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Workpiece {
    /// C of F = C·a_p^x·f^y·v^z, N at 1 mm, 1 mm/r and 1 m/min.
    pub coefficient_n: f64,
    /// x.
    pub depth_exponent: f64,
    /// y.
    pub feed_exponent: f64,
    /// z.
    pub speed_exponent: f64,
    /// Standard uncertainty of ln C.
    pub u_ln_coefficient: f64,
    /// Young's modulus, N/mm².
    pub youngs_modulus_n_per_mm2: f64,
    /// Chuck face to tailstock, mm.
    pub length_mm: f64,
    /// Diameter of the stock, mm.
    pub stock_diameter_mm: f64,
    /// Radial stiffness of the chuck, N/µm.
    pub chuck_n_per_um: f64,
    /// Radial stiffness of the tailstock, N/µm; 0 for a free end.
    pub tailstock_n_per_um: f64,
}

impl Default for Workpiece {
    /// The force law is Table 1 of the slender-shaft paper (45 steel), the shaft its preset's.
    fn default() -> Self {
        Self {
            coefficient_n: 4764.2,
            depth_exponent: 0.901,
            feed_exponent: 0.6,
            speed_exponent: -0.3,
            u_ln_coefficient: 0.3,
            youngs_modulus_n_per_mm2: 2.1e5,
            length_mm: 500.0,
            stock_diameter_mm: 27.0,
            chuck_n_per_um: 50.0,
            tailstock_n_per_um: 20.0,
        }
    }
}

/// Model-based controller: `[control.model]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ModelSettings {
    /// Force law assumed: radial force F = C·a_p^x·f^y·v^z in N; C. Left out: that of the job's
    /// material, by its specific cutting force.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coefficient_n: Option<f64>,
    /// Exponent of the depth of cut, 0 < x ≤ 2. Left out: the job's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_exponent: Option<f64>,
    /// Exponent of the feed. Left out: the job's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub feed_exponent: Option<f64>,
    /// Exponent of the cutting speed. Left out: the job's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_exponent: Option<f64>,
    /// Young's modulus, N/mm². Left out: that of the job's material.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub youngs_modulus_n_per_mm2: Option<f64>,
    /// Chuck face to tailstock, mm. Left out: the job's `part.length_mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length_mm: Option<f64>,
    /// Diameter of the stock, mm. Left out: the job's `part.stock_diameter_mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stock_diameter_mm: Option<f64>,
    /// Radial stiffness of the chuck, N/µm. Left out: the job's `process.support.chuck_n_per_um`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chuck_n_per_um: Option<f64>,
    /// Radial stiffness of the tailstock, N/µm. Left out: the job's
    /// `process.support.tailstock_n_per_um`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tailstock_n_per_um: Option<f64>,
    /// Standard uncertainty of ln C: .3 stands for about ± 30 %. Left out: .3, and .7 for a
    /// material without a specific cutting force.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub u_ln_coefficient: Option<f64>,
    /// Standard uncertainty of the logarithm of both stiffnesses: .7 stands for about a factor
    /// of 2.
    pub u_ln_stiffness: f64,
    /// Standard uncertainty of the stock's mean diameter, mm.
    pub u_stock_mean_mm: f64,
    /// Standard deviation of the stock's diameter along z, mm.
    pub stock_form_mm: f64,
    /// Standard deviation of a constant or a taper of the machine, mm of radius.
    pub u_machine_mm: f64,
    /// Standard deviation of what a pass adds to it (wear, warming), mm of radius a pass.
    pub u_trend_mm: f64,
    /// Standard deviation of what the model cannot explain at a station and that stays, mm of
    /// radius.
    pub u_station_mm: f64,
    /// Standard deviation of its growth at a station, mm of radius a pass.
    pub u_station_trend_mm: f64,
    /// Standard deviation of what a pass adds all along the shaft and the next does not repeat, mm
    /// of radius.
    pub u_pass_mm: f64,
    /// Standard deviation of what comes and goes at a station from pass to pass, mm of radius.
    pub repeatability_mm: f64,
}

impl Default for ModelSettings {
    /// Length, diameter, material, supports and force law come from the job.
    fn default() -> Self {
        Self {
            coefficient_n: None,
            depth_exponent: None,
            feed_exponent: None,
            speed_exponent: None,
            youngs_modulus_n_per_mm2: None,
            length_mm: None,
            stock_diameter_mm: None,
            chuck_n_per_um: None,
            tailstock_n_per_um: None,
            u_ln_coefficient: None,
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
    /// The table with every missing key filled from a workpiece.
    #[must_use]
    pub(crate) fn for_workpiece(&self, w: &Workpiece) -> Self {
        Self {
            coefficient_n: self.coefficient_n.or(Some(w.coefficient_n)),
            depth_exponent: self.depth_exponent.or(Some(w.depth_exponent)),
            feed_exponent: self.feed_exponent.or(Some(w.feed_exponent)),
            speed_exponent: self.speed_exponent.or(Some(w.speed_exponent)),
            u_ln_coefficient: self.u_ln_coefficient.or(Some(w.u_ln_coefficient)),
            youngs_modulus_n_per_mm2: self.youngs_modulus_n_per_mm2.or(Some(w.youngs_modulus_n_per_mm2)),
            length_mm: self.length_mm.or(Some(w.length_mm)),
            stock_diameter_mm: self.stock_diameter_mm.or(Some(w.stock_diameter_mm)),
            chuck_n_per_um: self.chuck_n_per_um.or(Some(w.chuck_n_per_um)),
            tailstock_n_per_um: self.tailstock_n_per_um.or(Some(w.tailstock_n_per_um)),
            ..self.clone()
        }
    }

    /// The workpiece assumed; keys left out are [`Workpiece::default`]'s.
    pub(crate) fn workpiece(&self) -> Workpiece {
        let w = Workpiece::default();
        Workpiece {
            coefficient_n: self.coefficient_n.unwrap_or(w.coefficient_n),
            depth_exponent: self.depth_exponent.unwrap_or(w.depth_exponent),
            feed_exponent: self.feed_exponent.unwrap_or(w.feed_exponent),
            speed_exponent: self.speed_exponent.unwrap_or(w.speed_exponent),
            u_ln_coefficient: self.u_ln_coefficient.unwrap_or(w.u_ln_coefficient),
            youngs_modulus_n_per_mm2: self.youngs_modulus_n_per_mm2.unwrap_or(w.youngs_modulus_n_per_mm2),
            length_mm: self.length_mm.unwrap_or(w.length_mm),
            stock_diameter_mm: self.stock_diameter_mm.unwrap_or(w.stock_diameter_mm),
            chuck_n_per_um: self.chuck_n_per_um.unwrap_or(w.chuck_n_per_um),
            tailstock_n_per_um: self.tailstock_n_per_um.unwrap_or(w.tailstock_n_per_um),
        }
    }

    /// Checks the table.
    ///
    /// # Errors
    /// [`SettingError`] names the key.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        let w = self.workpiece();
        let positive = [
            ("control.model.coefficient_n", w.coefficient_n),
            ("control.model.depth_exponent", w.depth_exponent),
            ("control.model.youngs_modulus_n_per_mm2", w.youngs_modulus_n_per_mm2),
            ("control.model.length_mm", w.length_mm),
            ("control.model.stock_diameter_mm", w.stock_diameter_mm),
            ("control.model.chuck_n_per_um", w.chuck_n_per_um),
            ("control.model.u_ln_coefficient", w.u_ln_coefficient),
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
            ("control.model.feed_exponent", w.feed_exponent),
            ("control.model.speed_exponent", w.speed_exponent),
        ] {
            require(value.is_finite(), key, value, "a finite exponent")?;
        }
        let t = w.tailstock_n_per_um;
        require(t >= 0.0, "control.model.tailstock_n_per_um", t, "a stiffness, 0 for a free end")?;
        let x = w.depth_exponent;
        require(x <= 2.0, "control.model.depth_exponent", x, "an exponent above 0 and at most 2")
    }
}
