//! The `[process]` table: what is cut, how it is held, how it yields and what the tool leaves on it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::beam::{Part, Supports};

/// A setting outside its range.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("process.{key} = {value} is not possible; it must be {must_be}")]
pub struct SettingsError {
    /// The key below `[process]`, dotted.
    pub key: String,
    /// The value found.
    pub value: f64,
    /// What would be right.
    pub must_be: String,
}

/// The `[process]` table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ProcessSettings {
    /// Radial cutting force against depth, feed and speed.
    pub force: ForceLaw,
    /// Elastic constants of the workpiece.
    pub material: MaterialSettings,
    /// How the workpiece is held.
    pub support: SupportSettings,
    /// What the tool leaves on the surface.
    pub texture: TextureSettings,
    /// Cut geometry and resolution.
    pub pass: PassSettings,
}

/// Radial cutting force in N.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ForceLaw {
    /// F = C·a_p^x·f^y·v^z.
    Power(PowerLaw),
}

impl Default for ForceLaw {
    fn default() -> Self {
        Self::Power(PowerLaw::default())
    }
}

/// F = C·a_p^x·f^y·v^z in N, with a_p in mm, f in mm/r and v in m/min.
///
/// The default is Table 1 of paper 003 (45 steel, slender shaft), fitted over a_p = 0.1-0.25 mm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PowerLaw {
    /// C, N at a_p = 1 mm, f = 1 mm/r, v = 1 m/min.
    pub coefficient_n: f64,
    /// x, exponent of the depth of cut.
    pub depth_exponent: f64,
    /// y, exponent of the feed.
    pub feed_exponent: f64,
    /// z, exponent of the cutting speed.
    pub speed_exponent: f64,
}

impl Default for PowerLaw {
    fn default() -> Self {
        Self { coefficient_n: 4764.2, depth_exponent: 0.901, feed_exponent: 0.6, speed_exponent: -0.3 }
    }
}

/// Elastic constants; the default is 45 steel (C45).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MaterialSettings {
    /// Young's modulus E, N/mm².
    pub youngs_modulus_n_per_mm2: f64,
    /// Poisson's ratio ν.
    pub poisson_ratio: f64,
}

impl Default for MaterialSettings {
    fn default() -> Self {
        Self { youngs_modulus_n_per_mm2: 2.1e5, poisson_ratio: 0.3 }
    }
}

/// How the workpiece is held: clamped in the chuck at z = 0, on a live centre in the tailstock at z = L.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SupportSettings {
    /// Radial stiffness of spindle and chuck, N/µm; `inf` for rigid.
    pub chuck_n_per_um: f64,
    /// Tilting stiffness of spindle and chuck, N·m/mrad; `inf` for rigid.
    pub chuck_tilt_nm_per_mrad: f64,
    /// Radial stiffness of the tailstock, N/µm; `inf` for rigid, 0 for a free end.
    pub tailstock_n_per_um: f64,
}

impl Default for SupportSettings {
    fn default() -> Self {
        Self { chuck_n_per_um: 50.0, chuck_tilt_nm_per_mrad: f64::INFINITY, tailstock_n_per_um: 20.0 }
    }
}

/// The surface that a pass leaves: correlated residual heights and small lobes, drawn from (seed, pass) alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TextureSettings {
    /// Standard deviation of the heights, µm; 0 for a smooth surface.
    pub rms_um: f64,
    /// Correlation length along z (autocorrelation 1/e), mm.
    pub correlation_z_mm: f64,
    /// Correlation length around the circumference (autocorrelation 1/e), degrees.
    pub correlation_deg: f64,
    /// Root mean square amplitude of each lobe of orders 2 to 5, µm.
    pub lobe_um: f64,
}

impl Default for TextureSettings {
    fn default() -> Self {
        Self { rms_um: 0.35, correlation_z_mm: 1.5, correlation_deg: 3.0, lobe_um: 0.3 }
    }
}

/// Cut geometry and resolution of the simulated pass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PassSettings {
    /// Distance of the nodes along z at which the cut is solved, mm.
    pub node_mm: f64,
    /// Depth of cut below which the edge rubs instead of cutting and the force law fails, mm.
    pub minimum_chip_mm: f64,
}

impl Default for PassSettings {
    fn default() -> Self {
        Self { node_mm: 1.0, minimum_chip_mm: 0.05 }
    }
}

/// A range a number must lie in.
struct Range {
    low: f64,
    open_low: bool,
    high: f64,
}

impl Range {
    const POSITIVE: Self = Self { low: 0.0, open_low: true, high: f64::INFINITY };
    const NOT_NEGATIVE: Self = Self { low: 0.0, open_low: false, high: f64::INFINITY };

    fn holds(&self, value: f64) -> bool {
        value <= self.high && if self.open_low { value > self.low } else { value >= self.low }
    }

    fn text(&self) -> String {
        let low = if self.open_low { "above" } else { "at least" };
        if self.high.is_finite() {
            format!("{low} {} and at most {}", self.low, self.high)
        } else {
            format!("{low} {}", self.low)
        }
    }
}

/// Refuses a value outside the range; an infinite one only where `infinite` allows it.
fn check(key: &str, value: f64, range: &Range, infinite: bool) -> Result<(), SettingsError> {
    if range.holds(value) && (infinite || value.is_finite()) {
        return Ok(());
    }
    let must_be = if infinite { format!("{} or inf", range.text()) } else { range.text() };
    Err(SettingsError { key: key.to_owned(), value, must_be })
}

impl ProcessSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// Names the first key out of range and what would be right.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let positive = |key: &str, value: f64| check(key, value, &Range::POSITIVE, false);
        let not_negative = |key: &str, value: f64| check(key, value, &Range::NOT_NEGATIVE, false);
        self.force.validate()?;
        positive("material.youngs_modulus_n_per_mm2", self.material.youngs_modulus_n_per_mm2)?;
        let poisson = Range { low: 0.0, open_low: false, high: 0.5 };
        check("material.poisson_ratio", self.material.poisson_ratio, &poisson, false)?;
        check("support.chuck_n_per_um", self.support.chuck_n_per_um, &Range::POSITIVE, true)?;
        let tilt = self.support.chuck_tilt_nm_per_mrad;
        check("support.chuck_tilt_nm_per_mrad", tilt, &Range::POSITIVE, true)?;
        check("support.tailstock_n_per_um", self.support.tailstock_n_per_um, &Range::NOT_NEGATIVE, true)?;
        not_negative("texture.rms_um", self.texture.rms_um)?;
        let along = Range { low: 0.2, open_low: false, high: 1000.0 };
        check("texture.correlation_z_mm", self.texture.correlation_z_mm, &along, false)?;
        let around = Range { low: 0.5, open_low: false, high: 60.0 };
        check("texture.correlation_deg", self.texture.correlation_deg, &around, false)?;
        not_negative("texture.lobe_um", self.texture.lobe_um)?;
        let node = Range { low: 0.01, open_low: false, high: 50.0 };
        check("pass.node_mm", self.pass.node_mm, &node, false)?;
        not_negative("pass.minimum_chip_mm", self.pass.minimum_chip_mm)
    }
}

impl SupportSettings {
    /// The ends as the beam needs them.
    pub fn supports(&self) -> Supports {
        // 1 N/µm = 1e3 N/mm; 1 N·m/mrad = 1e6 N·mm/rad.
        Supports {
            chuck: Part::clamped(1e-3 / self.chuck_n_per_um, 1e-6 / self.chuck_tilt_nm_per_mrad),
            tailstock: Part::hinged(1e-3 / self.tailstock_n_per_um),
            steady_rests: Vec::new(),
        }
    }
}

impl ForceLaw {
    fn validate(&self) -> Result<(), SettingsError> {
        match self {
            Self::Power(law) => law.validate(),
        }
    }
}

impl PowerLaw {
    fn validate(&self) -> Result<(), SettingsError> {
        check("force.power.coefficient_n", self.coefficient_n, &Range::POSITIVE, false)?;
        let falling = Range { low: 0.0, open_low: true, high: 2.0 };
        check("force.power.depth_exponent", self.depth_exponent, &falling, false)?;
        let either = Range { low: -3.0, open_low: false, high: 3.0 };
        check("force.power.feed_exponent", self.feed_exponent, &either, false)?;
        check("force.power.speed_exponent", self.speed_exponent, &either, false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_valid() {
        assert_eq!(ProcessSettings::default().validate(), Ok(()));
    }

    #[test]
    fn an_error_names_the_key_and_what_is_right() {
        let mut settings = ProcessSettings::default();
        settings.support.chuck_n_per_um = -1.0;
        let text = settings.validate().unwrap_err().to_string();
        assert!(text.contains("process.support.chuck_n_per_um"), "{text}");
        assert!(text.contains("above 0 or inf"), "{text}");
        settings.support.chuck_n_per_um = f64::NAN;
        assert!(settings.validate().is_err());
    }

    #[test]
    fn unknown_keys_are_refused_and_rigid_can_be_written() {
        assert!(toml::from_str::<ProcessSettings>("[support]\nchuck = 1").is_err());
        let settings: ProcessSettings = toml::from_str("[support]\ntailstock_n_per_um = inf").unwrap();
        assert_eq!(settings.support.tailstock_n_per_um, f64::INFINITY);
        assert_eq!(settings.validate(), Ok(()));
    }
}
