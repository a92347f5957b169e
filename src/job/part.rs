//! The part and its passes: the `[part]` table.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::part_section::PartSection;
use super::stations;
use crate::conformity::{DecisionRule, PROBABILITY, SizeCriterion, Tolerance};
use crate::setting::{SettingError, positive, require};

/// The part and its passes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Part {
    /// Length from the chuck face to the tailstock, mm.
    pub length_mm: f64,
    /// Diameter of the stock before the first pass, mm; with `[shaft] contour` that of its largest
    /// diameter, with the same allowance everywhere else (a pre-turned blank).
    pub stock_diameter_mm: f64,
    /// Nominal diameter r(k) of every pass, mm, falling; with `[shaft] contour` that of its largest
    /// diameter.
    pub nominal_diameter_mm: Vec<f64>,
    /// Added to the nominal of the last pass: where in its tolerance the part shall lie, mm; 0
    /// unless set.
    pub aim_mm: f64,
    /// Length of a station, mm.
    pub station_mm: f64,
    /// Middles of the stations, mm from the chuck face, ascending, where they do not lie side by
    /// side from end to end: each takes `station_mm` and lies inside the part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub station_z_mm: Option<Vec<f64>>,
    /// What the drawing states of the sections of `[shaft] contour`: tolerance, aim, name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sections: Vec<PartSection>,
    /// Tolerance of the finished part; without one no verdict is given. The sections of `[shaft]
    /// contour` have their own.
    #[serde(default)]
    pub tolerance: Option<Tolerance>,
    /// Probability with which conformity to the tolerance must be proven at every station (ISO
    /// 14253-1), 0.5 to 1.
    pub conformance_probability: f64,
}

impl Default for Part {
    fn default() -> Self {
        Self {
            length_mm: 500.0,
            stock_diameter_mm: 27.0,
            nominal_diameter_mm: vec![26.5, 26.0, 25.5, 25.0],
            aim_mm: 0.0,
            station_mm: 5.0,
            station_z_mm: None,
            sections: Vec::new(),
            tolerance: Some(Tolerance::new(25.0, 0.0, -0.013)),
            conformance_probability: PROBABILITY,
        }
    }
}

impl Part {
    /// Number of passes.
    pub(crate) fn passes(&self) -> usize {
        self.nominal_diameter_mm.len()
    }

    /// Target diameter of pass `pass` (from 1), mm: its nominal; for the last pass with the aim
    /// added.
    pub(crate) fn target_mm(&self, pass: u32) -> f64 {
        let index = (pass as usize).saturating_sub(1).min(self.passes().saturating_sub(1));
        let aim = if index + 1 == self.passes() { self.aim_mm } else { 0.0 };
        self.nominal_diameter_mm.get(index).copied().unwrap_or(self.stock_diameter_mm) + aim
    }

    /// Middles of the stations, mm from the chuck face: those listed, otherwise side by side from
    /// the chuck face; a remainder shorter than a station at the end is left out.
    pub(crate) fn station_z_mm(&self) -> Vec<f64> {
        if let Some(listed) = &self.station_z_mm {
            return listed.clone();
        }
        let count = (self.length_mm / self.station_mm + 1e-9).floor() as usize;
        (0..count).map(|i| (i as f64 + 0.5) * self.station_mm).collect()
    }

    /// The stations that the config lists.
    pub(super) fn listed(&self) -> Option<&[f64]> {
        self.station_z_mm.as_deref()
    }

    /// The last pass must aim inside the tolerance, or no part could ever be good.
    pub(super) fn check_aim(&self) -> Result<(), SettingError> {
        let Some(tolerance) = self.tolerance else { return Ok(()) };
        let (aim, (lower, upper)) = (self.target_mm(self.passes() as u32), tolerance.limits_mm());
        if (lower..=upper).contains(&aim) {
            return Ok(());
        }
        Err(SettingError::at(
            "part.tolerance.nominal_mm",
            format!(
                "{} mm: the last pass aims at {aim:.4} mm (part.nominal_diameter_mm and part.aim_mm), outside {lower:.4} to {upper:.4} mm",
                tolerance.nominal_mm
            ),
        ))
    }

    /// A warning where the last pass aims at a limit of its tolerance: half of all parts would lie
    /// outside.
    pub(super) fn aims_at_a_limit(&self) -> Option<String> {
        let (lower, upper) = self.tolerance?.limits_mm();
        let aim = self.target_mm(self.passes() as u32);
        let on_a_limit = (aim - lower).min(upper - aim).abs() < 1e-3 * (upper - lower);
        on_a_limit.then(|| {
            format!(
                "the last pass aims at {aim:.4} mm, a limit of its tolerance ({lower:.4} to {upper:.4} mm): part.aim_mm = {:.4} would aim \
                 at the middle",
                self.aim_mm + 0.5 * (lower + upper) - aim
            )
        })
    }

    pub(super) fn check(&self) -> Result<(), SettingError> {
        positive("part.length_mm", self.length_mm)?;
        positive("part.stock_diameter_mm", self.stock_diameter_mm)?;
        positive("part.station_mm", self.station_mm)?;
        if self.station_mm > self.length_mm {
            return Err(SettingError::at(
                "part.station_mm",
                format!(
                    "a station of {} mm is longer than the part ({} mm)",
                    self.station_mm, self.length_mm
                ),
            ));
        }
        if self.length_mm / self.station_mm > 1e5 {
            return Err(SettingError::at(
                "part.station_mm",
                "gives more than 100 000 stations; 1 to 10 mm is usual",
            ));
        }
        if let Some(listed) = self.listed() {
            stations::check(listed, self.length_mm, self.station_mm)?;
        }
        if self.nominal_diameter_mm.is_empty() {
            return Err(SettingError::at(
                "part.nominal_diameter_mm",
                "is empty; give the diameter of each pass",
            ));
        }
        let mut before = self.stock_diameter_mm;
        for (index, &nominal) in self.nominal_diameter_mm.iter().enumerate() {
            let key = format!("part.nominal_diameter_mm[{index}]");
            positive(&key, nominal)?;
            if nominal >= before {
                return Err(SettingError::at(
                    key,
                    format!("{nominal} mm does not remove material from {before} mm; diameters must fall"),
                ));
            }
            before = nominal;
        }
        require(self.aim_mm.is_finite(), "part.aim_mm", self.aim_mm, "a length in mm")?;
        self.check_tolerance()
    }

    pub(super) fn check_tolerance(&self) -> Result<(), SettingError> {
        DecisionRule::new(self.conformance_probability)
            .map_err(|e| SettingError::at("part.conformance_probability", e.to_string()))?;
        let Some(t) = self.tolerance else { return Ok(()) };
        if t.criterion != SizeCriterion::TwoPoint {
            let why = format!(
                "{} is judged by measure --turn: a run judges the stations' mean two-point sizes",
                t.criterion.as_str()
            );
            return Err(SettingError::at("part.tolerance", why));
        }
        // NaN is refused as well.
        if !(t.lower_mm < t.upper_mm) {
            return Err(SettingError::at(
                "part.tolerance.lower_mm",
                format!("{} mm must lie below upper_mm = {} mm", t.lower_mm, t.upper_mm),
            ));
        }
        Ok(())
    }
}
