//! The thermometer beside the masters while they are recorded.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::unstated::{Unstated, UnstatedLimits};
use crate::setting::{SettingError, within};

/// Temperature of the masters while they were recorded: one thermometer, one material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(from = "GivenThermometer")]
pub(crate) struct Thermometer {
    /// Temperature of the masters, °C. -50 ..= 400.
    pub temperature_c: f64,
    /// Limits of its error, ± K. 0 ..= 100.
    pub limit_temperature_k: f64,
    /// Coefficient of expansion of the masters, µm/(m·K). 0 ..= 100.
    pub expansion_um_per_m_k: f64,
    /// Limits of its error, ± µm/(m·K). 0 ..= 50.
    pub limit_expansion_um_per_m_k: f64,
    /// What of these nobody stated.
    #[serde(skip_serializing_if = "Unstated::is_empty")]
    pub unstated: Unstated,
}

impl Default for Thermometer {
    /// Known exactly: 20 °C.
    fn default() -> Self {
        Self {
            temperature_c: 20.0,
            limit_temperature_k: 0.0,
            expansion_um_per_m_k: 11.5,
            limit_expansion_um_per_m_k: 0.0,
            unstated: Unstated::default(),
        }
    }
}

/// A thermometer as a file gives it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct GivenThermometer {
    /// Temperature of the masters, °C.
    pub temperature_c: Option<f64>,
    /// Limits of its error, ± K.
    pub limit_temperature_k: Option<f64>,
    /// Coefficient of expansion of the masters, µm/(m·K).
    pub expansion_um_per_m_k: Option<f64>,
    /// Limits of its error, ± µm/(m·K).
    pub limit_expansion_um_per_m_k: Option<f64>,
}

impl From<GivenThermometer> for Thermometer {
    fn from(given: GivenThermometer) -> Self {
        let unstated_limits = UnstatedLimits::get();
        let unstated = if given.temperature_c.is_some() {
            unstated_limits.reading_k
        } else {
            unstated_limits.temperature_k
        };
        let exact = Self::default();
        Self {
            temperature_c: given.temperature_c.unwrap_or(exact.temperature_c),
            limit_temperature_k: given.limit_temperature_k.unwrap_or(unstated),
            expansion_um_per_m_k: given.expansion_um_per_m_k.unwrap_or(exact.expansion_um_per_m_k),
            limit_expansion_um_per_m_k: given
                .limit_expansion_um_per_m_k
                .unwrap_or(unstated_limits.expansion_um_per_m_k),
            unstated: Unstated {
                temperature: given.limit_temperature_k.is_none(),
                expansion: given.limit_expansion_um_per_m_k.is_none(),
                edge: false,
            },
        }
    }
}

impl Thermometer {
    /// Nothing stated: 20 °C within wide limits.
    pub(crate) fn unstated() -> Self {
        GivenThermometer::default().into()
    }

    /// Unstated limits taken as exact: for masters that were rendered.
    #[must_use]
    pub(crate) fn known(&self) -> Self {
        let keep = |limit: f64, unstated: bool| if unstated { 0.0 } else { limit };
        Self {
            limit_temperature_k: keep(self.limit_temperature_k, self.unstated.temperature),
            limit_expansion_um_per_m_k: keep(self.limit_expansion_um_per_m_k, self.unstated.expansion),
            unstated: Unstated::default(),
            ..*self
        }
    }

    /// Names of its two sources in budgets.
    pub(crate) fn sources(&self) -> [&'static str; 2] {
        [
            if self.unstated.temperature {
                "temperature of the masters, not stated"
            } else {
                "temperature of the masters"
            },
            if self.unstated.expansion {
                "expansion of the masters, not stated"
            } else {
                "expansion of the masters"
            },
        ]
    }

    /// Checks every range.
    ///
    /// # Errors
    /// Names the key.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        let at = |key: &str, v, low, high, right| within(&format!("thermometer.{key}"), v, low, high, right);
        at("temperature_c", self.temperature_c, -50.0, 400.0, "-50 to 400 °C")?;
        at("limit_temperature_k", self.limit_temperature_k, 0.0, 100.0, "0 to 100 K")?;
        at("expansion_um_per_m_k", self.expansion_um_per_m_k, 0.0, 100.0, "0 to 100 µm/(m K); steel 11.5")?;
        at("limit_expansion_um_per_m_k", self.limit_expansion_um_per_m_k, 0.0, 50.0, "0 to 50 µm/(m K)")
    }

    /// Standard uncertainties of T and α, K and 1/K.
    pub(crate) fn u(&self) -> [f64; 2] {
        let root = 3.0_f64.sqrt();
        [self.limit_temperature_k / root, 1e-6 * self.limit_expansion_um_per_m_k / root]
    }

    /// Coefficient of expansion of the masters, 1/K.
    pub(crate) fn alpha(&self) -> f64 {
        1e-6 * self.expansion_um_per_m_k
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_stated_of_the_masters_has_wide_limits() {
        let read = |text: &str| toml::from_str::<Thermometer>(text).unwrap();
        assert_eq!((read("").limit_temperature_k, read("").limit_expansion_um_per_m_k), (5.0, 1.0));
        assert_eq!(read("temperature_c = 21.3").limit_temperature_k, 1.0);
        assert_eq!(read("").sources()[0], "temperature of the masters, not stated");
        let stated = read("limit_temperature_k = 0.2\nlimit_expansion_um_per_m_k = 0.0");
        assert!(stated.unstated.is_empty() && stated.sources()[0] == "temperature of the masters");
        assert_eq!(read("").known(), Thermometer::default());
        assert!(toml::from_str::<Thermometer>("limit_k = 1.0").is_err());
    }
}
