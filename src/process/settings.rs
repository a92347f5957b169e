//! The `[process]` table: force law, material, tool, supports, bending, surface texture, pass and
//! disturbances.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::beam::{Part, SteadyRest, Supports};
use super::bending::BendingSettings;
use super::check::{Range, refuse};
use super::disturbance::DisturbanceSettings;
use super::force::ForceLaw;
use super::material::{self, Material};
use super::tool::ToolSettings;
use crate::plan::FeedDirection;
use crate::setting::SettingError;

/// The `[process]` table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ProcessSettings {
    /// Cutting force against depth, feed and speed.
    pub force: ForceLaw,
    /// The workpiece's material.
    pub material: MaterialSettings,
    /// The cutting edge.
    pub tool: ToolSettings,
    /// How the workpiece is held.
    pub support: SupportSettings,
    /// What bends the axis besides the radial force.
    pub bending: BendingSettings,
    /// What the tool leaves on the surface.
    pub texture: TextureSettings,
    /// Cut geometry and resolution.
    pub pass: PassSettings,
    /// Wear, drift, scatter and errors of the machine; none by default.
    pub disturbance: DisturbanceSettings,
}

/// The workpiece's material: a name from the table, and numbers that override the table's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MaterialSettings {
    /// Name; the default is the slender-shaft paper's 45 steel.
    pub name: String,
    /// Young's modulus E, N/mm².
    pub youngs_modulus_n_per_mm2: Option<f64>,
    /// Poisson's ratio ν.
    pub poisson_ratio: Option<f64>,
    /// Linear thermal expansion, µm/(m·K).
    pub expansion_um_per_m_k: Option<f64>,
    /// Density, kg/m³.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density_kg_per_m3: Option<f64>,
}

impl Default for MaterialSettings {
    fn default() -> Self {
        Self {
            name: "C45".to_owned(),
            youngs_modulus_n_per_mm2: None,
            poisson_ratio: None,
            expansion_um_per_m_k: None,
            density_kg_per_m3: None,
        }
    }
}

impl MaterialSettings {
    /// The material with the config's numbers in place of the table's.
    ///
    /// # Errors
    /// A name that is not in the table, or a number out of range.
    pub(crate) fn resolve(&self) -> Result<Material, SettingError> {
        let known = material::find(&self.name)
            .ok_or_else(|| refuse("material.name", &self.name, format!("one of {}", material::names())))?;
        let resolved = Material {
            youngs_modulus_n_per_mm2: self.youngs_modulus_n_per_mm2.unwrap_or(known.youngs_modulus_n_per_mm2),
            poisson_ratio: self.poisson_ratio.unwrap_or(known.poisson_ratio),
            expansion_um_per_m_k: self.expansion_um_per_m_k.unwrap_or(known.expansion_um_per_m_k),
            density_kg_per_m3: self.density_kg_per_m3.unwrap_or(known.density_kg_per_m3),
            ..*known
        };
        Range::POSITIVE.check("material.youngs_modulus_n_per_mm2", resolved.youngs_modulus_n_per_mm2)?;
        Range::between(0.0, 0.5).check("material.poisson_ratio", resolved.poisson_ratio)?;
        Range::between(0.0, 100.0).check("material.expansion_um_per_m_k", resolved.expansion_um_per_m_k)?;
        Range::between(100.0, 25e3).check("material.density_kg_per_m3", resolved.density_kg_per_m3)?;
        Ok(resolved)
    }
}

/// A steady rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SteadyRestSettings {
    /// Where it stands, mm from the chuck face; acts at the nearest node.
    pub z_mm: f64,
    /// Radial stiffness, N/µm; `inf` for rigid.
    pub stiffness_n_per_um: f64,
}

/// How the workpiece is held: clamped in the chuck at z = 0, on a live centre in the tailstock at
/// z = L.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SupportSettings {
    /// Radial stiffness of spindle and chuck, N/µm; `inf` for rigid.
    pub chuck_n_per_um: f64,
    /// Tilting stiffness of spindle and chuck, N·m/mrad; `inf` for rigid.
    pub chuck_tilt_nm_per_mrad: f64,
    /// Radial stiffness of the tailstock, N/µm; `inf` for rigid, 0 for a free end.
    pub tailstock_n_per_um: f64,
    /// Axial thrust of the tailstock, N: a shaft that would buckle under it is refused.
    pub tailstock_thrust_n: f64,
    /// Steady rests.
    pub steady_rests: Vec<SteadyRestSettings>,
}

impl Default for SupportSettings {
    fn default() -> Self {
        Self {
            chuck_n_per_um: 50.0,
            chuck_tilt_nm_per_mrad: f64::INFINITY,
            tailstock_n_per_um: 20.0,
            tailstock_thrust_n: 300.0,
            steady_rests: Vec::new(),
        }
    }
}

impl SupportSettings {
    /// Supports as the beam needs them.
    pub(crate) fn supports(&self) -> Supports {
        // 1 N/µm = 1e3 N/mm; 1 N·m/mrad = 1e6 N·mm/rad.
        let rest = |rest: &SteadyRestSettings| SteadyRest {
            z_mm: rest.z_mm,
            compliance_mm_per_n: 1e-3 / rest.stiffness_n_per_um,
        };
        Supports {
            chuck: Part::clamped(1e-3 / self.chuck_n_per_um, 1e-6 / self.chuck_tilt_nm_per_mrad),
            tailstock: Part::hinged(1e-3 / self.tailstock_n_per_um),
            steady_rests: self.steady_rests.iter().map(rest).collect(),
        }
    }
}

/// The surface that a pass leaves: correlated residual heights and small lobes, drawn from (seed,
/// pass) alone.
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
    /// Draws the helical feed marks, f²/8r high, as well (a fine grid: tens of MB for a long
    /// shaft).
    pub feed_marks: bool,
}

impl Default for TextureSettings {
    fn default() -> Self {
        Self { rms_um: 0.35, correlation_z_mm: 1.5, correlation_deg: 3.0, lobe_um: 0.3, feed_marks: false }
    }
}

/// What happens where the depth falls below the minimum chip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BelowMinimumChip {
    /// The pass is refused.
    #[default]
    Refuse,
    /// The force law is used below its limit (spring passes), and the summary says so.
    Extrapolate,
}

/// Cut geometry and resolution of the simulated pass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PassSettings {
    /// Distance of the nodes along z at which the cut is solved, mm.
    pub node_mm: f64,
    /// Depth of cut below which the edge rubs instead of cutting and the force law fails, mm.
    pub minimum_chip_mm: f64,
    /// What happens there.
    pub below_minimum_chip: BelowMinimumChip,
    /// The way the tool travels.
    pub feed_direction: FeedDirection,
}

impl Default for PassSettings {
    fn default() -> Self {
        Self {
            node_mm: 1.0,
            minimum_chip_mm: 0.05,
            below_minimum_chip: BelowMinimumChip::default(),
            feed_direction: FeedDirection::default(),
        }
    }
}

impl ProcessSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// Names the first key out of range and what would be right.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        let material = self.material.resolve()?;
        self.force.validate(&material)?;
        self.tool.validate("tool")?;
        self.support.validate()?;
        self.bending.validate()?;
        self.texture.validate()?;
        Range::between(0.01, 50.0).check("pass.node_mm", self.pass.node_mm)?;
        Range::NOT_NEGATIVE.check("pass.minimum_chip_mm", self.pass.minimum_chip_mm)?;
        self.disturbance.validate()
    }
}

impl SupportSettings {
    fn validate(&self) -> Result<(), SettingError> {
        let stiff = Range::POSITIVE.or_infinite();
        stiff.check("support.chuck_n_per_um", self.chuck_n_per_um)?;
        stiff.check("support.chuck_tilt_nm_per_mrad", self.chuck_tilt_nm_per_mrad)?;
        Range::NOT_NEGATIVE.or_infinite().check("support.tailstock_n_per_um", self.tailstock_n_per_um)?;
        Range::NOT_NEGATIVE.check("support.tailstock_thrust_n", self.tailstock_thrust_n)?;
        for (index, rest) in self.steady_rests.iter().enumerate() {
            let key = |name: &str| format!("support.steady_rests[{index}].{name}");
            stiff.check(&key("stiffness_n_per_um"), rest.stiffness_n_per_um)?;
            Range::POSITIVE.check(&key("z_mm"), rest.z_mm)?;
        }
        Ok(())
    }
}

impl TextureSettings {
    fn validate(&self) -> Result<(), SettingError> {
        Range::NOT_NEGATIVE.check("texture.rms_um", self.rms_um)?;
        Range::between(0.2, 1000.0).check("texture.correlation_z_mm", self.correlation_z_mm)?;
        Range::between(0.5, 60.0).check("texture.correlation_deg", self.correlation_deg)?;
        Range::NOT_NEGATIVE.check("texture.lobe_um", self.lobe_um)
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
        assert!(text.contains("process.support.chuck_n_per_um = -1"), "{text}");
        assert!(text.contains("above 0 or inf"), "{text}");
        settings.support.chuck_n_per_um = f64::NAN;
        assert!(settings.validate().is_err());
    }

    #[test]
    fn a_material_without_data_is_named() {
        let mut settings = ProcessSettings::default();
        settings.material.name = "unobtainium".to_owned();
        let text = settings.validate().unwrap_err().to_string();
        assert!(text.contains("unobtainium") && text.contains("42CrMo4"), "{text}");
        settings.material.name = "EN AW-6082".to_owned();
        assert_eq!(settings.validate(), Ok(()));
        settings.force = ForceLaw::Kienzle(super::super::kienzle::KienzleLaw::default());
        let text = settings.validate().unwrap_err().to_string();
        assert!(text.contains("force.kienzle.kc11_n_per_mm2") && text.contains("EN AW-6082"), "{text}");
    }

    #[test]
    fn unknown_keys_are_refused_and_rigid_can_be_written() {
        assert!(toml::from_str::<ProcessSettings>("[support]\nchuck = 1").is_err());
        let settings: ProcessSettings = toml::from_str("[support]\ntailstock_n_per_um = inf").unwrap();
        assert_eq!(settings.support.tailstock_n_per_um, f64::INFINITY);
        assert_eq!(settings.validate(), Ok(()));
    }
}
