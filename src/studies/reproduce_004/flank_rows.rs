//! The flank of Table 1: classes, the blunting standard with an uncertainty, and what its words on
//! the direction of a width leave open.

use super::inputs::{Inputs, MICROMETRE_MM, PrintedLand};
use crate::conformity::{DecisionRule, MANY};
use crate::studies::reproduction::{Accept, Row};
use crate::tool::wear::{Land, WearClass, WearLimits};

/// Lands of Table 1: their name in an id, and the class that the paper gives them.
const CLASSES: [(&str, WearClass); 3] =
    [("slight", WearClass::Slight), ("uniform", WearClass::Uniform), ("non_uniform", WearClass::NonUniform)];

pub(super) fn rows(inputs: &Inputs) -> Vec<Row> {
    let each = inputs.lands.iter().zip(CLASSES).flat_map(|(land, (name, _))| {
        let id = |figure: &str| format!("flank.{name}.{figure}");
        vec![
            Row::ours(
                (&id("ratio"), "largest over mean width of the land, VBmax/VB", ""),
                land.vb_max_mm / land.vb_mm,
                "Table 1",
            ),
            Row::ours(
                (&id("u"), "largest standard uncertainty with which the edge is proven to be sharp", "mm"),
                largest_u_mm(land),
                "what is left to .3 mm of VB and .6 mm of VBmax, the lesser, over the guard factor of 95 % (ISO 14253-1); \
                 Table 1 states no uncertainty",
            ),
        ]
    });
    each.chain([
        Row::printed(
            ("flank.blunt", "lands of Table 1 at or above the blunting standard", ""),
            Some(0.0),
            inputs.lands.iter().filter(|land| largest_u_mm(land) <= 0.0).count() as f64,
            Accept::Absolute(0.0),
            "section 2: none reaches .3 mm of VB or .6 mm of VBmax",
        ),
        Row::in_sample(
            ("flank.classes", "lands of Table 1 in the class that the paper gives them", ""),
            Some(CLASSES.len() as f64),
            inputs.lands.iter().zip(CLASSES).filter(|(land, (_, class))| land.class() == *class).count()
                as f64,
            Accept::Absolute(0.0),
            "slight below VB .1 mm, not uniform from VBmax/VB 2: bounds of ours that were set by these three",
        ),
        direction(inputs),
    ])
    .collect()
}

/// Section 2 has VBmax "in the y-axis direction" and D_i as the distance from the fitted curve S.
fn direction(inputs: &Inputs) -> Row {
    let widest = inputs.lands.iter().map(|land| land.vb_max_mm).fold(0.0, f64::max);
    Row::ours(
        (
            "flank.direction",
            "tilt of the edge in the image from which a width along y is wrong in its last digit",
            "°",
        ),
        (widest / (widest + MICROMETRE_MM)).acos().to_degrees(),
        "a width along y is that at right angles to S over the cosine of the tilt; the paper has both, and states no tilt",
    )
}

fn largest_u_mm(land: &PrintedLand) -> f64 {
    let (limits, rule) = (WearLimits::default(), DecisionRule::default());
    // one limit alone: the guard band of u = 1
    let factor = rule.guard_mm(1.0, MANY, f64::INFINITY).unwrap_or(f64::NAN);
    let left_mm = |limit_um: f64, mm: f64| 1e-3 * limit_um - mm;
    left_mm(limits.vbb_um, land.vb_mm).min(left_mm(limits.vbb_max_um, land.vb_max_mm)) / factor
}

impl PrintedLand {
    /// Its class by [`Land::class`].
    fn class(&self) -> WearClass {
        let um = |mm: f64| (1e3 * mm, f64::NAN);
        Land { vbb_um: um(self.vb_mm), vbb_max_um: um(self.vb_max_mm) }.class()
    }
}
