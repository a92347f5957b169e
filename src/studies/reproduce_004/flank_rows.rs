//! The flank of Table 1: classes, verdicts by the paper's rule and by ours, the blunting standard
//! with an uncertainty, and what its words on the direction of a width leave open.

use super::inputs::{Inputs, MICROMETRE_MM, PrintedLand};
use crate::conformity::{DecisionRule, MANY};
use crate::studies::reproduction::{Accept, Row};
use crate::tool::wear::{Land, WearClass, WearLimits, WearVerdict};

/// Limits of the blunting standard as section 2 has them, mm.
const VB_LIMIT_MM: f64 = 0.3;
const VB_MAX_LIMIT_MM: f64 = 0.6;

/// Lands of Table 1: their name in an id, and the class that the paper gives them.
const CLASSES: [(&str, WearClass); 3] =
    [("slight", WearClass::Slight), ("uniform", WearClass::Uniform), ("non_uniform", WearClass::NonUniform)];

pub(super) fn rows(inputs: &Inputs) -> Vec<Row> {
    let each = inputs.lands.iter().zip(CLASSES).flat_map(|(land, (name, class))| {
        let id = |figure: &str| format!("flank.{name}.{figure}");
        let mut of_land = decided(land, class, inputs.scale_um_per_px, &id);
        of_land.extend([
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
        ]);
        of_land
    });
    each.chain(limits(inputs)).chain([
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

/// Class and verdict of a land, by the paper's rule and by ours.
fn decided(land: &PrintedLand, class: WearClass, u_um: f64, id: &impl Fn(&str) -> String) -> Vec<Row> {
    let number = |class: WearClass| match class {
        WearClass::New => 0.0,
        WearClass::Slight => 1.0,
        WearClass::Uniform => 2.0,
        WearClass::NonUniform => 3.0,
    };
    // one limit a land: of VB where it is uniform, of VBmax where it is not
    let (width_mm, limit_mm) = match class {
        WearClass::NonUniform => (land.vb_max_mm, VB_MAX_LIMIT_MM),
        _ => (land.vb_mm, VB_LIMIT_MM),
    };
    vec![
        Row::in_sample(
            (&id("class"), "class of the land: 1 slight, 2 uniform, 3 not uniform", ""),
            Some(number(class)),
            number(land.class()),
            Accept::Absolute(0.0),
            "by VB and VBmax/VB alone; the paper names the class and gives no rule for it",
        ),
        Row::printed(
            (&id("blunt"), "blunt by the paper's rule: 1, to be used on: 0", ""),
            Some(0.0),
            f64::from(u8::from(width_mm > limit_mm)),
            Accept::Absolute(0.0),
            format!(
                "{width_mm} mm beside {limit_mm} mm; section 2: the tools of Table 1 do not reach the blunting standard"
            ),
        ),
        Row::ours(
            (&id("sharp"), "proven to be sharp at a standard uncertainty of one pixel: 1", ""),
            f64::from(u8::from(land.at(u_um).verdict(&WearLimits::default()) == WearVerdict::Sharp)),
            "both widths below their limits by 1.645 u (ISO 14253-1, 95 %); the paper compares widths without an uncertainty",
        ),
    ]
}

/// The blunting standard and what a pixel is of it.
fn limits(inputs: &Inputs) -> Vec<Row> {
    let ours = WearLimits::default();
    let limit = |names: (&str, &str, &str), paper_mm: f64, ours_um: f64| {
        Row::in_sample(
            names,
            Some(paper_mm),
            1e-3 * ours_um,
            Accept::Absolute(1e-9),
            "ISO 3685:1993, 7.1.1, which is the default of `tool flank`",
        )
    };
    let least = inputs.lands.iter().map(|land| land.vb_mm).fold(f64::INFINITY, f64::min);
    vec![
        limit(("flank.limit.vb", "limit of VB of a uniform land", "mm"), VB_LIMIT_MM, ours.vbb_um),
        limit(
            ("flank.limit.vb_max", "limit of VBmax of a land that is not uniform", "mm"),
            VB_MAX_LIMIT_MM,
            ours.vbb_max_um,
        ),
        Row::ours(
            ("flank.pixels", "least VB of Table 1 in pixels", "px"),
            1e3 * least / inputs.scale_um_per_px,
            "by S, which section 2 gives for the nose; the flank's own scale is not printed",
        ),
        Row::ours(
            ("flank.digit", "last digit of Table 1 in pixels", "px"),
            2e3 * MICROMETRE_MM / inputs.scale_um_per_px,
            "less than half a pixel: a mean over many columns may have it, a largest width of one column does not",
        ),
    ]
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
    /// Its widths with one standard uncertainty.
    fn at(&self, u_um: f64) -> Land {
        let um = |mm: f64| (1e3 * mm, u_um);
        Land { vbb_um: um(self.vb_mm), vbb_max_um: um(self.vb_max_mm) }
    }

    /// Its class by [`Land::class`].
    fn class(&self) -> WearClass {
        self.at(f64::NAN).class()
    }
}
