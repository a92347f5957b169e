//! The tool's geometry: `[process.tool]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::Range;
use crate::setting::SettingError;

/// The cutting edge; the default is the slender-shaft paper's insert.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ToolSettings {
    /// Nose radius, mm; handbook factors on the force from 0.5 to 5 mm, extrapolated beyond.
    pub nose_radius_mm: f64,
    /// Lead (cutting edge) angle κ_r of the straight edge, degrees; handbook factors on the force
    /// from 30 to 90°, held beyond.
    pub lead_angle_deg: f64,
    /// Rake angle γ, degrees; handbook factors on the force from -15 to 20°, held beyond.
    pub rake_deg: f64,
    /// Relief angle α, degrees; handbooks give no factor on the force.
    pub relief_deg: f64,
    /// Minor cutting edge angle κ'_r, degrees: with the nose radius, the height of the feed marks.
    pub minor_angle_deg: f64,
    /// Inclination λ_s of the major cutting edge (ISO 3002-1), degrees; handbook factors on the
    /// force from -15 to 5°, held beyond.
    pub inclination_deg: f64,
}

impl Default for ToolSettings {
    fn default() -> Self {
        Self {
            nose_radius_mm: 0.4,
            lead_angle_deg: 90.0,
            rake_deg: 15.0,
            relief_deg: 6.0,
            minor_angle_deg: 15.0,
            inclination_deg: 0.0,
        }
    }
}

impl ToolSettings {
    /// Checks every number; `prefix` is the table's dotted key below `process`.
    pub(super) fn validate(&self, prefix: &str) -> Result<(), SettingError> {
        let key = |name: &str| format!("{prefix}.{name}");
        Range::POSITIVE.check(&key("nose_radius_mm"), self.nose_radius_mm)?;
        Range::between(15.0, 90.0).check(&key("lead_angle_deg"), self.lead_angle_deg)?;
        // Inserts are made with rakes from -15° to 30°; a wedge angle below 45° is too weak to cut.
        Range::between(-15.0, 30.0).check(&key("rake_deg"), self.rake_deg)?;
        Range::between(0.5, 20.0).check(&key("relief_deg"), self.relief_deg)?;
        Range::between(0.5, 90.0).check(&key("minor_angle_deg"), self.minor_angle_deg)?;
        Range::between(-15.0, 15.0).check(&key("inclination_deg"), self.inclination_deg)
    }
}
