//! The conditions a part is measured under, as far as its diameter at 20 °C depends on them.
//!
//! D₂₀ = D_T/(1 + α(T − 20 °C)) (ISO 1). What a condition is not known to comes in as a rectangular distribution of the
//! half width given, u = half/√3 (GUM 4.3.7).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::SettingError;

/// Reference temperature of ISO 1, °C.
const REFERENCE_C: f64 = 20.0;

/// Temperature, position and finish of the part while it is measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Conditions {
    /// Temperature of the part, °C. -50 ..= 400.
    pub temperature_c: f64,
    /// Limits of its error, ± K. 0 ..= 100.
    pub limit_temperature_k: f64,
    /// Coefficient of expansion of the part, µm/(m·K). 0 ..= 100.
    pub expansion_um_per_m_k: f64,
    /// Limits of its error, ± µm/(m·K). 0 ..= 50.
    pub limit_expansion_um_per_m_k: f64,
    /// Distance of the axis from the plane of the masters, towards the camera, mm. -1000 ..= 1000.
    pub axis_y_mm: f64,
    /// Limits of its error, ± mm. 0 ..= 100.
    pub limit_axis_y_mm: f64,
    /// Limits within which an edge of the part differs from one of the masters (finish, edge shape), ± µm an edge. 0 ..= 100.
    pub limit_edge_um: f64,
    /// Limits of the scale's drift since the calibration, ± ppm. 0 ..= 1e5.
    pub limit_drift_ppm: f64,
}

impl Default for Conditions {
    /// Exactly 20 °C, exactly in the masters' plane, edges like the masters'.
    fn default() -> Self {
        Self {
            temperature_c: REFERENCE_C,
            limit_temperature_k: 0.0,
            expansion_um_per_m_k: 11.5,
            limit_expansion_um_per_m_k: 0.0,
            axis_y_mm: 0.0,
            limit_axis_y_mm: 0.0,
            limit_edge_um: 0.0,
            limit_drift_ppm: 0.0,
        }
    }
}

impl Conditions {
    /// Checks every range.
    ///
    /// # Errors
    /// Names the key.
    pub fn validate(&self) -> Result<(), SettingError> {
        let at = |key: &str, value, low, high, right| {
            super::within(&format!("conditions.{key}"), value, low, high, right)
        };
        at("temperature_c", self.temperature_c, -50.0, 400.0, "-50 to 400 °C")?;
        at("limit_temperature_k", self.limit_temperature_k, 0.0, 100.0, "0 to 100 K")?;
        at("expansion_um_per_m_k", self.expansion_um_per_m_k, 0.0, 100.0, "0 to 100 µm/(m K); steel 11.5")?;
        at("limit_expansion_um_per_m_k", self.limit_expansion_um_per_m_k, 0.0, 50.0, "0 to 50 µm/(m K)")?;
        at("axis_y_mm", self.axis_y_mm, -1e3, 1e3, "a distance in mm")?;
        at("limit_axis_y_mm", self.limit_axis_y_mm, 0.0, 100.0, "0 to 100 mm")?;
        at("limit_edge_um", self.limit_edge_um, 0.0, 100.0, "0 to 100 µm")?;
        at("limit_drift_ppm", self.limit_drift_ppm, 0.0, 1e5, "0 to 100 000 ppm")
    }

    /// D₂₀/D_T.
    pub fn to_reference(&self) -> f64 {
        1.0 / (1.0 + 1e-6 * self.expansion_um_per_m_k * (self.temperature_c - REFERENCE_C))
    }

    /// Standard uncertainty of D₂₀ by the part's temperature, mm. Both factors of α(T − 20) are uncertain: near 20 °C
    /// the product of their errors counts too (GUM 5.1.2, note).
    pub fn u_temperature_mm(&self, diameter_mm: f64) -> f64 {
        let u = self.limit_temperature_k / 3.0_f64.sqrt();
        let product = 1e-6 * self.limit_expansion_um_per_m_k / 3.0_f64.sqrt() * u;
        diameter_mm * (1e-6 * self.expansion_um_per_m_k * u).hypot(product)
    }

    /// Standard uncertainty of D₂₀ by the part's coefficient of expansion, mm.
    pub fn u_expansion_mm(&self, diameter_mm: f64) -> f64 {
        diameter_mm * 1e-6 * self.limit_expansion_um_per_m_k / 3.0_f64.sqrt()
            * (self.temperature_c - REFERENCE_C).abs()
    }

    /// Standard uncertainty by the axis' place before the camera, mm: t·y with t known to `u_t`, 1/mm.
    pub fn u_focus_mm(&self, diameter_mm: f64, t_per_mm: f64, u_t_per_mm: f64) -> f64 {
        diameter_mm * t_per_mm.hypot(u_t_per_mm) * self.limit_axis_y_mm / 3.0_f64.sqrt()
    }

    /// Standard uncertainty by edges unlike the masters', mm of diameter: both edges are of one finish.
    pub fn u_edges_mm(&self) -> f64 {
        2e-3 * self.limit_edge_um / 3.0_f64.sqrt()
    }

    /// Standard uncertainty by the scale's drift, mm.
    pub fn u_drift_mm(&self, diameter_mm: f64) -> f64 {
        diameter_mm * 1e-6 * self.limit_drift_ppm / 3.0_f64.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warm_part_is_smaller_at_20_degrees() {
        let warm = Conditions { temperature_c: 30.0, ..Conditions::default() };
        let at_20 = 25.002_875 * warm.to_reference();
        assert!((at_20 - 25.0).abs() < 1e-9, "{at_20}");
        let uncertain = Conditions { limit_temperature_k: 3.0_f64.sqrt(), ..warm };
        // 1 K of standard uncertainty: 25 mm x 11.5 ppm.
        assert!((uncertain.u_temperature_mm(25.0) - 25.0 * 11.5e-6).abs() < 1e-12);
        let expansion = Conditions { limit_expansion_um_per_m_k: 3.0_f64.sqrt(), ..warm };
        assert!((expansion.u_expansion_mm(25.0) - 25.0 * 1e-5).abs() < 1e-12);
    }

    #[test]
    fn a_wrong_condition_is_named() {
        let wrong = Conditions { temperature_c: f64::NAN, ..Conditions::default() };
        assert_eq!(wrong.validate().unwrap_err().key, "conditions.temperature_c");
        assert!(toml::from_str::<Conditions>("temperature = 20.0").is_err());
    }
}
