//! Kienzle's law along an edge with a nose radius.
//!
//! At every point of the engaged edge the chip is h = f·sin κ thick, κ being the lead angle there;
//! a width ds of the edge carries the cutting force dF_c = kc1.1·h^(1-mc)·ds and, in the tool
//! plane, a force normal to the edge dF_n = ρ·dF_c, of which sin κ points against the feed and cos
//! κ radially. On the nose (radius r) κ runs from 0 at the tip to κ_e with r(1 - cos κ_e) = a_p,
//! and only beyond the nose the straight edge with κ_r begins:
//!
//! ```text
//! F_p = ρ·kc1.1·f^(1-mc)·[ r·sin^(2-mc)κ_e/(2-mc) + l·sin^(1-mc)κ_r·cos κ_r ]
//! ```
//!
//! with l the engaged length of the straight edge. The shallower the cut, the larger the radial
//! share of the force; with κ_r = 90° the radial force stops growing once a_p reaches r. Valid for
//! f well below r and for chips thicker than the edge rounding. (O. Kienzle, VDI-Z 94, 1952; edge
//! integration as in G. Boothroyd and W. Knight, Fundamentals of Machining.)

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::{Range, refuse};
use super::force_components::Components;
use super::material::Material;
use super::tool::ToolSettings;
use super::tool_factors::ToolFactors;
use crate::setting::SettingError;

/// Chips thinner than this lie below the data that kc1.1 and mc were fitted to; there k_c rises
/// faster, mm.
pub(crate) const THINNEST_CHIP_MM: f64 = 0.05;

/// `[process.force.kienzle]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct KienzleLaw {
    /// kc1.1, N/mm²; the material's value where it is left out.
    pub kc11_n_per_mm2: Option<f64>,
    /// mc; the material's value where it is left out.
    pub mc: Option<f64>,
    /// ρ: force normal to the edge over cutting force. Handbooks give 0.3 to 0.5 for sharp tools;
    /// wear raises it.
    pub normal_ratio: f64,
    /// Factor on all components for speed and wear; rake and inclination of the tool have factors
    /// of their own ([`super::tool_factors`]).
    pub correction: f64,
}

impl Default for KienzleLaw {
    fn default() -> Self {
        Self { kc11_n_per_mm2: None, mc: None, normal_ratio: 0.45, correction: 1.0 }
    }
}

impl KienzleLaw {
    pub(super) fn validate(&self, material: &Material) -> Result<(), SettingError> {
        for (key, own, known) in [
            ("force.kienzle.kc11_n_per_mm2", self.kc11_n_per_mm2, material.kienzle.map(|k| k.kc11_n_per_mm2)),
            ("force.kienzle.mc", self.mc, material.kienzle.map(|k| k.mc)),
        ] {
            let value = own.or(known).ok_or_else(|| {
                refuse(key, "(not set)", format!("given: the table has no value for {}", material.name))
            })?;
            let range = if key.ends_with("mc") { Range::between(0.0, 0.9) } else { Range::POSITIVE };
            range.check(key, value)?;
        }
        Range::POSITIVE.check("force.kienzle.normal_ratio", self.normal_ratio)?;
        Range::POSITIVE.check("force.kienzle.correction", self.correction)
    }

    /// Mean chip thickness a_p·f over the engaged length of the edge, mm.
    pub(crate) fn mean_chip_mm(feed_mm: f64, depth_mm: f64, tool: &ToolSettings) -> f64 {
        let lead = tool.lead_angle_deg.to_radians();
        let nose_depth = tool.nose_radius_mm * (1.0 - lead.cos());
        let engaged = (1.0 - depth_mm.min(nose_depth) / tool.nose_radius_mm).acos();
        let straight = (depth_mm - nose_depth).max(0.0) / lead.sin();
        depth_mm * feed_mm / (tool.nose_radius_mm * engaged + straight)
    }

    /// The law on a tool at a feed; `None` where neither the config nor the material has a value.
    pub(crate) fn at(&self, feed_mm: f64, tool: &ToolSettings, material: &Material) -> Option<EdgeLaw> {
        let kc11 = self.kc11_n_per_mm2.or(material.kienzle.map(|k| k.kc11_n_per_mm2))?;
        let mc = self.mc.or(material.kienzle.map(|k| k.mc))?;
        let lead = tool.lead_angle_deg.to_radians();
        Some(EdgeLaw {
            per_length_n: kc11 * self.correction * feed_mm.powf(1.0 - mc),
            exponent: 1.0 - mc,
            normal_ratio: self.normal_ratio,
            nose_radius_mm: tool.nose_radius_mm,
            sin_lead: lead.sin(),
            // cos 90° is 6e-17 in doubles; the radial share of the straight edge is exactly zero
            // there.
            cos_lead: if tool.lead_angle_deg == 90.0 { 0.0 } else { lead.cos() },
            factors: ToolFactors::beside_the_edge(tool),
        })
    }
}

/// Kienzle's law for a tool at a feed: forces as functions of the depth alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EdgeLaw {
    per_length_n: f64,
    exponent: f64,
    normal_ratio: f64,
    nose_radius_mm: f64,
    sin_lead: f64,
    cos_lead: f64,
    /// Factors for rake and inclination.
    factors: ToolFactors,
}

/// Nodes and weights of the eight-point Gauss-Legendre rule on 0..1, one half (the other is its
/// mirror image).
const GAUSS: [(f64, f64); 4] = [
    (0.019_855_071_751_231_884, 0.050_614_268_145_188_13),
    (0.101_666_761_293_186_63, 0.111_190_517_226_687_24),
    (0.237_233_795_041_835_5, 0.156_853_322_938_943_64),
    (0.408_282_678_752_175_1, 0.181_341_891_689_180_98),
];

impl EdgeLaw {
    /// Depth at which the nose ends and the straight edge begins, mm.
    fn nose_depth_mm(&self) -> f64 {
        self.nose_radius_mm * (1.0 - self.cos_lead)
    }

    /// Sine of the lead angle where the engaged part of the nose ends.
    fn sin_engaged(&self, depth_mm: f64) -> f64 {
        let cos = 1.0 - depth_mm.min(self.nose_depth_mm()) / self.nose_radius_mm;
        (1.0 - cos * cos).max(0.0).sqrt()
    }

    /// Engaged length of the straight edge, mm.
    fn straight_mm(&self, depth_mm: f64) -> f64 {
        (depth_mm - self.nose_depth_mm()).max(0.0) / self.sin_lead
    }

    /// Radial (passive) force, N.
    pub(crate) fn passive_n(&self, depth_mm: f64) -> f64 {
        if depth_mm <= 0.0 {
            return 0.0;
        }
        let nose = self.nose_radius_mm * self.sin_engaged(depth_mm).powf(1.0 + self.exponent)
            / (1.0 + self.exponent);
        let straight = self.straight_mm(depth_mm) * self.sin_lead.powf(self.exponent) * self.cos_lead;
        self.factors.passive * self.normal_ratio * self.per_length_n * (nose + straight)
    }

    /// dF_p/da, N/mm: the edge element that the next depth engages.
    pub(crate) fn passive_slope_n_per_mm(&self, depth_mm: f64) -> f64 {
        let (sin, cos) = if depth_mm < self.nose_depth_mm() {
            (self.sin_engaged(depth_mm), 1.0 - depth_mm / self.nose_radius_mm)
        } else {
            (self.sin_lead, self.cos_lead)
        };
        self.factors.passive * self.normal_ratio * self.per_length_n * sin.powf(self.exponent - 1.0) * cos
    }

    /// All three components, N.
    pub(crate) fn components(&self, depth_mm: f64) -> Components {
        if depth_mm <= 0.0 {
            return Components::default();
        }
        let sin = self.sin_engaged(depth_mm);
        let cos = 1.0 - depth_mm.min(self.nose_depth_mm()) / self.nose_radius_mm;
        let engaged = sin.atan2(cos);
        let straight = self.straight_mm(depth_mm) * self.sin_lead.powf(self.exponent);
        let cutting = self.nose_radius_mm * power_of_sine(engaged, self.exponent) + straight;
        let feed =
            self.nose_radius_mm * power_of_sine(engaged, 1.0 + self.exponent) + straight * self.sin_lead;
        Components {
            cutting_n: self.factors.cutting * self.per_length_n * cutting,
            feed_n: self.factors.feed * self.normal_ratio * self.per_length_n * feed,
            passive_n: self.passive_n(depth_mm),
        }
    }
}

/// ∫₀^end sin^p κ dκ for 0 < end ≤ π/2 and p > 0. With κ = end·t² the integrand is smooth enough
/// for an eight-point rule (relative error below 1e-5).
fn power_of_sine(end: f64, p: f64) -> f64 {
    let at = |t: f64| 2.0 * t * end * (end * t * t).sin().powf(p);
    GAUSS.iter().map(|&(t, weight)| weight * (at(t) + at(1.0 - t))).sum()
}
