//! Cutting force as a function of the actual depth of cut.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::Range;
use super::force_components::Components;
use super::kienzle::{EdgeLaw, KienzleLaw, THINNEST_CHIP_MM};
use super::material::Material;
use super::tool::ToolSettings;
use super::tool_factors::ToolFactors;
use crate::plan::CuttingData;
use crate::setting::SettingError;

/// The material of Tables 1 and 2 of the slender-shaft paper, by its name in the table of
/// materials.
pub(crate) const FITTED_TO: &str = "C45";

/// The force law, `[process.force.power]` or `[process.force.kienzle]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ForceLaw {
    /// F = C·a_p^x·f^y·v^z for the radial force.
    Power(PowerLaw),
    /// Kienzle's specific cutting force along an edge with a nose radius.
    Kienzle(KienzleLaw),
}

impl Default for ForceLaw {
    fn default() -> Self {
        Self::Power(PowerLaw::default())
    }
}

/// Range of the data behind a fitted law; outside it the law is extrapolated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FittedRange {
    /// Depth of cut, mm, from and to.
    pub depth_mm: [f64; 2],
    /// Feed, mm/r, from and to.
    pub feed_mm_per_rev: [f64; 2],
    /// Cutting speed, m/min, from and to.
    pub speed_m_per_min: [f64; 2],
}

impl Default for FittedRange {
    /// Where data of the slender-shaft paper support the default law: depths of Table 1, to which C
    /// and x are fitted; feeds of Fig. 9, whose errors follow from y within 5 %; speeds of Table 2,
    /// whose own z is the same.
    fn default() -> Self {
        Self { depth_mm: [0.10, 0.38], feed_mm_per_rev: [0.05, 0.35], speed_m_per_min: [30.0, 100.0] }
    }
}

impl FittedRange {
    /// Table 1 of the slender-shaft paper alone: one feed, one speed.
    pub(crate) const TABLE_1: Self =
        Self { depth_mm: [0.10, 0.38], feed_mm_per_rev: [0.10, 0.10], speed_m_per_min: [40.0, 40.0] };
    /// Table 2 alone: one depth, one feed.
    pub(crate) const TABLE_2: Self =
        Self { depth_mm: [0.20, 0.20], feed_mm_per_rev: [0.10, 0.10], speed_m_per_min: [30.0, 100.0] };
}

/// F = C·a_p^x·f^y·v^z, the radial force in N, with a_p in mm, f in mm/r and v in m/min.
///
/// The default is Table 1 of the slender-shaft paper (Xue et al., 2023; 45 steel), x and C fitted,
/// y and z from handbooks.
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
    /// Cutting force over radial force; a rule of thumb, used for the tangential deflection only.
    pub cutting_ratio: f64,
    /// Feed force over radial force; a rule of thumb, used against buckling only.
    pub feed_ratio: f64,
    /// Range of the data behind the numbers.
    pub fitted: FittedRange,
    /// The tool behind the numbers (the slender-shaft paper's insert): another tool's forces follow
    /// by the handbook's factors, see `tool_factors`.
    pub fitted_tool: ToolSettings,
}

impl Default for PowerLaw {
    fn default() -> Self {
        Self {
            coefficient_n: 4764.2,
            depth_exponent: 0.901,
            feed_exponent: 0.6,
            speed_exponent: -0.3,
            cutting_ratio: 2.5,
            feed_ratio: 1.0,
            fitted: FittedRange::default(),
            fitted_tool: ToolSettings::default(),
        }
    }
}

/// A force law at given feed, speed and tool: a function of the depth alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DepthLaw {
    shape: Shape,
    /// Factor on every component: scatter of the material, wear.
    factor: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    Power { at_one_mm_n: f64, exponent: f64, cutting_ratio: f64, feed_ratio: f64 },
    Edge(EdgeLaw),
}

impl DepthLaw {
    /// The same law with every force multiplied.
    #[must_use]
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Self { factor: self.factor * factor, ..self }
    }

    /// Radial force in N at a depth in mm; zero without contact.
    pub(crate) fn force_n(&self, depth_mm: f64) -> f64 {
        let plain = match &self.shape {
            _ if depth_mm <= 0.0 => 0.0,
            Shape::Power { at_one_mm_n, exponent, .. } => at_one_mm_n * depth_mm.powf(*exponent),
            Shape::Edge(edge) => edge.passive_n(depth_mm),
        };
        self.factor * plain
    }

    /// Slope of the radial force, N/mm, at a depth above zero.
    pub(crate) fn slope_n_per_mm(&self, depth_mm: f64) -> f64 {
        match &self.shape {
            Shape::Power { exponent, .. } => exponent * self.force_n(depth_mm) / depth_mm,
            Shape::Edge(edge) => self.factor * edge.passive_slope_n_per_mm(depth_mm),
        }
    }

    /// All three components in N at a depth in mm.
    pub(crate) fn components(&self, depth_mm: f64) -> Components {
        match &self.shape {
            Shape::Power { cutting_ratio, feed_ratio, .. } => {
                let passive_n = self.force_n(depth_mm);
                Components { cutting_n: cutting_ratio * passive_n, feed_n: feed_ratio * passive_n, passive_n }
            }
            Shape::Edge(edge) => {
                let plain = edge.components(depth_mm);
                Components {
                    cutting_n: self.factor * plain.cutting_n,
                    feed_n: self.factor * plain.feed_n,
                    passive_n: self.factor * plain.passive_n,
                }
            }
        }
    }

    /// The actual depth of cut a, mm, where the tool is set a₀ = `set_mm` deep and the shaft has
    /// the compliance w = `compliance_mm_per_n`: the root of a + w·F(a) = a₀. Newton's method kept
    /// inside its bracket, to 1e-13 mm or the resolution of a double.
    pub(crate) fn depth_mm(&self, set_mm: f64, compliance_mm_per_n: f64) -> f64 {
        if set_mm <= 0.0 {
            return 0.0;
        }
        let (mut low, mut high, mut depth) = (0.0, set_mm, set_mm);
        for _ in 0..100 {
            let excess = depth - set_mm + compliance_mm_per_n * self.force_n(depth);
            (low, high) = if excess > 0.0 { (low, depth) } else { (depth, high) };
            let step = excess / (1.0 + compliance_mm_per_n * self.slope_n_per_mm(depth));
            let next = depth - step;
            let next = if next >= low && next <= high { next } else { 0.5 * (low + high) };
            if (next - depth).abs() <= 1e-13 * (1.0 + depth) {
                return next;
            }
            depth = next;
        }
        depth
    }
}

impl PowerLaw {
    /// Table 1 of the slender-shaft paper: the depth series, over its own range.
    pub(crate) fn table_1() -> Self {
        Self { fitted: FittedRange::TABLE_1, ..Self::default() }
    }

    /// Table 2 of the slender-shaft paper: the speed series at one depth, whose forces are 9.14
    /// times smaller than Table 1's at the same cutting data. C is the geometric mean over its rows
    /// with z = -0.3 and a handbook's x.
    pub(crate) fn table_2() -> Self {
        Self { coefficient_n: 521.2, depth_exponent: 0.9, fitted: FittedRange::TABLE_2, ..Self::default() }
    }

    /// Radial force, N, at a depth in mm.
    pub(crate) fn force_n(&self, depth_mm: f64, cutting: &CuttingData) -> f64 {
        self.at(cutting).force_n(depth_mm)
    }

    /// The law at the given cutting data, with the tool that it was fitted to.
    pub(crate) fn at(&self, cutting: &CuttingData) -> DepthLaw {
        self.with_factors(cutting, &ToolFactors::ONE)
    }

    /// The law at the given cutting data, with another tool.
    pub(crate) fn with_tool(&self, cutting: &CuttingData, tool: &ToolSettings) -> DepthLaw {
        self.with_factors(cutting, &ToolFactors::of(tool).over(&ToolFactors::of(&self.fitted_tool)))
    }

    fn with_factors(&self, cutting: &CuttingData, tool: &ToolFactors) -> DepthLaw {
        let factor = cutting.feed_mm_per_rev.powf(self.feed_exponent)
            * cutting.speed_m_per_min.powf(self.speed_exponent);
        let shape = Shape::Power {
            at_one_mm_n: self.coefficient_n * factor * tool.passive,
            exponent: self.depth_exponent,
            cutting_ratio: self.cutting_ratio * (tool.cutting / tool.passive),
            feed_ratio: self.feed_ratio * (tool.feed / tool.passive),
        };
        DepthLaw { shape, factor: 1.0 }
    }

    fn validate(&self) -> Result<(), SettingError> {
        let exponent = Range::between(-3.0, 3.0);
        Range::POSITIVE.check("force.power.coefficient_n", self.coefficient_n)?;
        Range::between(0.01, 2.0).check("force.power.depth_exponent", self.depth_exponent)?;
        exponent.check("force.power.feed_exponent", self.feed_exponent)?;
        exponent.check("force.power.speed_exponent", self.speed_exponent)?;
        Range::NOT_NEGATIVE.check("force.power.cutting_ratio", self.cutting_ratio)?;
        Range::NOT_NEGATIVE.check("force.power.feed_ratio", self.feed_ratio)?;
        let FittedRange { depth_mm, feed_mm_per_rev, speed_m_per_min } = self.fitted;
        for (name, [low, high]) in [
            ("depth_mm", depth_mm),
            ("feed_mm_per_rev", feed_mm_per_rev),
            ("speed_m_per_min", speed_m_per_min),
        ] {
            let key = format!("force.power.fitted.{name}");
            Range::NOT_NEGATIVE.check(&key, low)?;
            Range::between(low, f64::MAX).check(&key, high)?;
        }
        self.fitted_tool.validate("force.power.fitted_tool")
    }
}

impl ForceLaw {
    /// The law at the given cutting data, tool and material. Without any data for the material the
    /// force is zero; [`super::ProcessSettings::validate`] refuses that.
    pub(crate) fn at(&self, cutting: &CuttingData, tool: &ToolSettings, material: &Material) -> DepthLaw {
        match self {
            Self::Power(law) => law.with_tool(cutting, tool),
            Self::Kienzle(law) => match law.at(cutting.feed_mm_per_rev, tool, material) {
                Some(edge) => DepthLaw { shape: Shape::Edge(edge), factor: 1.0 },
                None => PowerLaw::default().at(cutting).scaled(0.0),
            },
        }
    }

    /// A note where the law was fitted to another material than the one cut: Table 1 is for 45
    /// steel, and its numbers do not follow `process.material`; a coefficient set in the config is
    /// assumed to belong to the material set there.
    pub(crate) fn of_another_material(&self, material: &Material) -> Option<String> {
        let table_1 =
            matches!(self, Self::Power(law) if law.coefficient_n == PowerLaw::table_1().coefficient_n);
        (table_1 && material.name != FITTED_TO).then(|| {
            format!(
                "process.force.power is fitted to 45 steel ({FITTED_TO}) and does not follow process.material.name = {}: give its \
                 coefficient_n, or take process.force.kienzle",
                material.name
            )
        })
    }

    /// What lies outside the range of the data behind the law, in words; empty inside it.
    /// `depth_mm` from and to.
    pub(crate) fn extrapolation(
        &self,
        cutting: &CuttingData,
        depth_mm: [f64; 2],
        tool: &ToolSettings,
    ) -> Vec<String> {
        let Self::Power(PowerLaw { fitted, .. }) = self else {
            let chip = KienzleLaw::mean_chip_mm(cutting.feed_mm_per_rev, depth_mm[0], tool);
            let thin = chip < THINNEST_CHIP_MM;
            let note = format!(
                "the force law is extrapolated: chips {chip:.4} mm thick, tabulated from {THINNEST_CHIP_MM} mm; the force \
                 is underestimated"
            );
            return if thin { vec![note] } else { Vec::new() };
        };
        let feed = [cutting.feed_mm_per_rev; 2];
        let speed = [cutting.speed_m_per_min; 2];
        [
            ("depth", "mm", depth_mm, fitted.depth_mm),
            ("feed", "mm/r", feed, fitted.feed_mm_per_rev),
            ("speed", "m/min", speed, fitted.speed_m_per_min),
        ]
        .into_iter()
        .filter(|(_, _, used, known)| used[0] < known[0] || used[1] > known[1])
        .map(|(name, unit, used, known)| {
            format!(
                "the force law is extrapolated: {name} {:.4}-{:.4} {unit}, fitted over {}-{} {unit}",
                used[0], used[1], known[0], known[1]
            )
        })
        .collect()
    }

    pub(super) fn validate(&self, material: &Material) -> Result<(), SettingError> {
        match self {
            Self::Power(law) => law.validate(),
            Self::Kienzle(law) => law.validate(material),
        }
    }
}
