//! `study deflection`: deflection of a supported shaft under a radial force, over the position of
//! the force.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::process::stepped::{Piece, SteppedShaft};
use crate::process::{ProcessSettings, Section};
use crate::setting::{SettingError, positive, require};

/// What to study: a shaft and how it is held.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct DeflectionConfig {
    /// Name, for reports.
    #[serde(default)]
    pub name: String,
    /// The shaft.
    pub part: BeamPart,
    /// Material and supports; the rest of the table does not matter here.
    #[serde(default)]
    pub process: ProcessSettings,
}

/// The shaft's shape.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BeamPart {
    /// Length from the chuck face to the tailstock, mm.
    pub length_mm: f64,
    /// Diameter, mm.
    pub stock_diameter_mm: f64,
    /// Diameter behind the tool, mm (it travels towards the chuck); the stock's where it is left
    /// out.
    #[serde(default)]
    pub cut_diameter_mm: Option<f64>,
    /// Steps: diameters other than the stock's.
    #[serde(default)]
    pub steps: Vec<Step>,
}

/// A step of the shaft.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Step {
    /// From, mm.
    pub from_mm: f64,
    /// To, mm.
    pub to_mm: f64,
    /// Diameter, mm.
    pub diameter_mm: f64,
}

/// Why a study is refused.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub(crate) enum DeflectionError {
    /// A setting of the process or of the part.
    #[error(transparent)]
    Settings(#[from] SettingError),
    /// A position outside the shaft.
    #[error("--at {z_mm}: outside the shaft; it must lie between 0 and {length_mm} mm")]
    Outside {
        /// Position, mm.
        z_mm: f64,
        /// Length, mm.
        length_mm: f64,
    },
}

/// Deflection at a position of the load.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Deflection {
    /// Position of the load, mm from the chuck face.
    pub z_mm: f64,
    /// Radial deflection at the load per newton, mm/N.
    pub compliance_mm_per_n: f64,
}

/// Result of the study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct DeflectionStudy {
    /// The requested positions.
    pub positions: Vec<Deflection>,
    /// The position of the largest deflection.
    pub max: Deflection,
}

impl DeflectionConfig {
    /// The beam, checked.
    ///
    /// # Errors
    /// A value out of range, or steps that overlap or leave the shaft.
    pub(crate) fn shaft(&self) -> Result<SteppedShaft, DeflectionError> {
        self.process.validate()?;
        let material = self.process.material.resolve()?;
        let part = &self.part;
        positive("part.length_mm", part.length_mm)?;
        positive("part.stock_diameter_mm", part.stock_diameter_mm)?;
        let cut = part.cut_diameter_mm.unwrap_or(part.stock_diameter_mm);
        positive("part.cut_diameter_mm", cut)?;
        let plain = |length_mm: f64| Piece {
            length_mm,
            ahead: Section::circular(part.stock_diameter_mm, &material),
            behind: Section::circular(cut, &material),
        };
        let (mut pieces, mut at) = (Vec::new(), 0.0);
        for (index, step) in part.steps.iter().enumerate() {
            let key = |name: &str| format!("part.steps[{index}].{name}");
            positive(&key("diameter_mm"), step.diameter_mm)?;
            in_order(&key("from_mm"), step.from_mm, at, part.length_mm)?;
            in_order(&key("to_mm"), step.to_mm, step.from_mm, part.length_mm)?;
            let section = Section::circular(step.diameter_mm, &material);
            pieces.push(plain(step.from_mm - at));
            pieces.push(Piece { length_mm: step.to_mm - step.from_mm, ahead: section, behind: section });
            at = step.to_mm;
        }
        pieces.push(plain(part.length_mm - at));
        Ok(SteppedShaft { pieces, supports: self.process.support.supports() })
    }

    /// Runs the study at the positions given; without any, at eleven equally spaced ones.
    ///
    /// # Errors
    /// As [`Self::shaft`], and a position outside the shaft.
    pub(crate) fn run(&self, at_mm: &[f64]) -> Result<DeflectionStudy, DeflectionError> {
        let shaft = self.shaft()?;
        let length_mm = self.part.length_mm;
        if let Some(&z_mm) = at_mm.iter().find(|z| !(0.0..=length_mm).contains(*z)) {
            return Err(DeflectionError::Outside { z_mm, length_mm });
        }
        let spaced: Vec<f64> = (0..=10).map(|i| f64::from(i) * length_mm / 10.0).collect();
        let wanted = if at_mm.is_empty() { &spaced } else { at_mm };
        let at = |&z_mm: &f64| Deflection { z_mm, compliance_mm_per_n: shaft.compliance_mm_per_n(z_mm) };
        let softest = shaft.softest();
        Ok(DeflectionStudy {
            positions: wanted.iter().map(at).collect(),
            max: Deflection { z_mm: softest.z_mm, compliance_mm_per_n: softest.compliance_mm_per_n },
        })
    }
}

fn in_order(key: &str, value: f64, from: f64, to: f64) -> Result<(), SettingError> {
    let right = format!("between {from} and {to} mm (steps ascend and do not overlap)");
    require((from..=to).contains(&value), key, value, &right)
}
