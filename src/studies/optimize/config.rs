//! The config of `shadowgauge optimize`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::point::Point;
use crate::process::ProcessSettings;
use crate::setting::{SettingError, positive, require};

/// A choice of cutting data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct OptimizeConfig {
    /// Name, for reports.
    #[serde(default)]
    pub name: String,
    /// The part.
    pub part: OptimizePart,
    /// Force, material, tool and supports.
    #[serde(default)]
    pub process: ProcessSettings,
    /// Bounds of the cutting data.
    pub limits: Limits,
    /// What the part must keep.
    pub quality: Quality,
    /// Tool life.
    #[serde(default)]
    pub tool_life: ToolLife,
    /// Times beside the cut.
    #[serde(default)]
    pub time: TimeModel,
    /// The genetic algorithm.
    #[serde(default)]
    pub genetic: GeneticSettings,
    /// Points of the front of time against size error.
    #[serde(default = "default_front_points")]
    pub front_points: usize,
    /// Points to compare with.
    #[serde(default)]
    pub reference: Vec<Reference>,
}

fn default_front_points() -> usize {
    24
}

/// The part to finish.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct OptimizePart {
    /// Length, mm.
    pub length_mm: f64,
    /// Diameter, mm.
    pub diameter_mm: f64,
    /// Number of passes n in equation 5.
    #[serde(default = "one")]
    pub passes: u32,
}

fn one() -> u32 {
    1
}

/// Bounds, from and to (equation 9).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Limits {
    /// Cutting speed, m/min.
    pub speed_m_per_min: [f64; 2],
    /// Feed, mm/r.
    pub feed_mm_per_rev: [f64; 2],
    /// Depth of cut, mm.
    pub depth_mm: [f64; 2],
}

/// What the part must keep (equations 7 and 8).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Quality {
    /// Allowed size error ΔD, mm of diameter.
    pub size_error_mm: f64,
    /// Part of it that other causes use up, mm (0.01 in equation 7).
    pub reserve_mm: f64,
    /// Allowed roughness R_a, µm (the paper compares it with the height of the feed marks).
    pub roughness_um: f64,
}

/// Taylor's tool life T = (C_T/(v·f^y·a_p^x))^(1/m), min. Defaults are handbook values for carbide
/// on 45 steel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct ToolLife {
    /// C_T, m/min at T = 1 min, f = 1 mm/r, a_p = 1 mm.
    pub(crate) constant_m_per_min: f64,
    /// y.
    pub feed_exponent: f64,
    /// x.
    pub depth_exponent: f64,
    /// m.
    pub life_exponent: f64,
}

impl Default for ToolLife {
    fn default() -> Self {
        Self { constant_m_per_min: 291.0, feed_exponent: 0.20, depth_exponent: 0.15, life_exponent: 0.2 }
    }
}

/// Times beside the cut (equation 4).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct TimeModel {
    /// t_h, one tool change, min.
    pub tool_change_min: f64,
    /// t_q, everything else, min.
    pub auxiliary_min: f64,
}

impl Default for TimeModel {
    fn default() -> Self {
        Self { tool_change_min: 1.0, auxiliary_min: 0.5 }
    }
}

/// The genetic algorithm's settings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct GeneticSettings {
    /// Evaluations of the model.
    pub evaluations: usize,
    /// Individuals.
    pub population: usize,
    /// Distribution index of the simulated binary crossover: larger keeps children nearer to their
    /// parents.
    pub crossover_index: f64,
    /// Distribution index of the polynomial mutation.
    pub mutation_index: f64,
    /// Probability that a variable mutates.
    pub mutation_rate: f64,
    /// Seed.
    pub seed: u64,
}

impl Default for GeneticSettings {
    fn default() -> Self {
        Self {
            evaluations: 10_000,
            population: 40,
            crossover_index: 5.0,
            mutation_index: 20.0,
            mutation_rate: 0.33,
            seed: 1,
        }
    }
}

/// A point to compare with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Reference {
    /// Its name.
    pub name: String,
    /// Cutting speed, m/min.
    pub speed_m_per_min: f64,
    /// Feed, mm/r.
    pub feed_mm_per_rev: f64,
    /// Depth of cut, mm.
    pub depth_mm: f64,
}

impl Reference {
    /// The point itself.
    pub(crate) fn point(&self) -> Point {
        Point {
            speed_m_per_min: self.speed_m_per_min,
            feed_mm_per_rev: self.feed_mm_per_rev,
            depth_mm: self.depth_mm,
        }
    }
}

impl OptimizeConfig {
    /// Checks every number.
    ///
    /// # Errors
    /// Names the first key out of range; bounds that exclude each other are such a key.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        self.process.validate()?;
        let (part, quality, life) = (&self.part, &self.quality, &self.tool_life);
        positive("part.length_mm", part.length_mm)?;
        positive("part.diameter_mm", part.diameter_mm)?;
        bounds("limits.speed_m_per_min", self.limits.speed_m_per_min)?;
        bounds("limits.feed_mm_per_rev", self.limits.feed_mm_per_rev)?;
        bounds("limits.depth_mm", self.limits.depth_mm)?;
        let removed = 2.0 * f64::from(part.passes) * self.limits.depth_mm[1];
        let right = format!(
            "small enough to leave a shaft: passes·2·depth = {removed} mm of {} mm",
            part.diameter_mm
        );
        require(removed < part.diameter_mm, "limits.depth_mm[1]", self.limits.depth_mm[1], &right)?;
        positive("quality.roughness_um", quality.roughness_um)?;
        positive("quality.size_error_mm", quality.size_error_mm)?;
        let right = format!("at least 0 and below quality.size_error_mm = {}", quality.size_error_mm);
        let in_range = (0.0..quality.size_error_mm).contains(&quality.reserve_mm);
        require(in_range, "quality.reserve_mm", quality.reserve_mm, &right)?;
        positive("tool_life.constant_m_per_min", life.constant_m_per_min)?;
        positive("tool_life.life_exponent", life.life_exponent)?;
        not_negative("tool_life.feed_exponent", life.feed_exponent)?;
        not_negative("tool_life.depth_exponent", life.depth_exponent)?;
        not_negative("time.tool_change_min", self.time.tool_change_min)?;
        not_negative("time.auxiliary_min", self.time.auxiliary_min)?;
        self.genetic.validate()?;
        for (index, reference) in self.reference.iter().enumerate() {
            positive(&format!("reference[{index}].speed_m_per_min"), reference.speed_m_per_min)?;
            positive(&format!("reference[{index}].feed_mm_per_rev"), reference.feed_mm_per_rev)?;
            positive(&format!("reference[{index}].depth_mm"), reference.depth_mm)?;
        }
        Ok(())
    }
}

impl GeneticSettings {
    fn validate(&self) -> Result<(), SettingError> {
        let (population, evaluations) = (self.population, self.evaluations);
        require(
            (4..=100_000).contains(&population),
            "genetic.population",
            population,
            "between 4 and 100000",
        )?;
        let enough = (2 * population..=100_000_000).contains(&evaluations);
        require(
            enough,
            "genetic.evaluations",
            evaluations,
            "at least twice genetic.population and at most 1e8",
        )?;
        not_negative("genetic.crossover_index", self.crossover_index)?;
        not_negative("genetic.mutation_index", self.mutation_index)?;
        let rate = self.mutation_rate;
        require((0.0..=1.0).contains(&rate), "genetic.mutation_rate", rate, "between 0 and 1")
    }
}

fn not_negative(key: &str, value: f64) -> Result<(), SettingError> {
    require(value >= 0.0 && value.is_finite(), key, value, "at least 0")
}

fn bounds(key: &str, [low, high]: [f64; 2]) -> Result<(), SettingError> {
    positive(&format!("{key}[0]"), low)?;
    positive(&format!("{key}[1]"), high)?;
    let right = format!("at least the lower bound {low}; the bounds exclude each other");
    require(low <= high, &format!("{key}[1]"), high, &right)
}
