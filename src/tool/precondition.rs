//! The precondition of correcting one cut by another one (NIST, process-intermittent gauging): both
//! have the same speed, feed and depth.
//!
//! What a nose leaves of a surface is geometry alone, but its offsets were set, and its wear was
//! found, with the deflection, the heat and the built-up edge of a cut. A correction by what was
//! measured holds where the next cut has them too.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::plan::CuttingData;
use crate::setting::{SettingError, positive};

/// The pass after which a nose was measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MeasuredPass {
    /// Its cutting speed, m/min.
    pub speed_m_per_min: f64,
    /// Its feed, mm per revolution.
    pub feed_mm_per_rev: f64,
    /// Its depth of cut, mm of radius; not compared where it is not stated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth_mm: Option<f64>,
}

/// Share by which cutting data may differ: `cutting_tolerance` of the controllers' guards.
const SAME_SHARE: f64 = 1e-3;
/// Depths that are the same, mm: rounding of diameters in increments.
const SAME_DEPTH_MM: f64 = 1e-3;

impl MeasuredPass {
    /// Checks the values themselves.
    ///
    /// # Errors
    /// The first that is no cutting data.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        positive("measured_pass.speed_m_per_min", self.speed_m_per_min)?;
        positive("measured_pass.feed_mm_per_rev", self.feed_mm_per_rev)?;
        self.depth_mm.map_or(Ok(()), |depth| positive("measured_pass.depth_mm", depth))
    }

    /// Whether a cut may be corrected by what this pass showed; `depth` is its depth of cut, mm of
    /// radius, with the key that it follows from.
    ///
    /// # Errors
    /// The first value that differs, at the key of the cut, with that of this pass.
    pub(crate) fn allows(
        &self,
        cutting: &CuttingData,
        depth: Option<(&str, f64)>,
    ) -> Result<(), SettingError> {
        let differs = |was: f64, is: f64| (is - was).abs() > SAME_SHARE * was;
        let right = |was: f64, unit: &str| {
            format!(
                "{was} {unit} as in the pass after which the nose was measured (measured_pass of the tool): a correction \
                 holds for the same speed, feed and depth; cut with these, or measure the nose after a pass like this one"
            )
        };
        let (was, is) = (self.speed_m_per_min, cutting.speed_m_per_min);
        if differs(was, is) {
            return Err(SettingError::of("cutting.speed_m_per_min", is, right(was, "m/min")));
        }
        let (was, is) = (self.feed_mm_per_rev, cutting.feed_mm_per_rev);
        if differs(was, is) {
            return Err(SettingError::of("cutting.feed_mm_per_rev", is, right(was, "mm per revolution")));
        }
        match (self.depth_mm, depth) {
            (Some(was), Some((key, is))) if (is - was).abs() > SAME_DEPTH_MM.max(SAME_SHARE * was) => {
                let problem = format!("a depth of cut of {is:.4} mm must be {}", right(was, "mm"));
                Err(SettingError::at(key, problem))
            }
            _ => Ok(()),
        }
    }
}
