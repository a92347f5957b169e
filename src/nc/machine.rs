//! The surroundings of the part, and how the control reads offsets: the keys of `machine.toml` that
//! have no default.
//!
//! Lengths are mm, X is a diameter, Z runs from the face that clamps the part (0) towards the
//! tailstock. Where a value is missing, a safe bound is assumed if there is one, and listed in the
//! program's header.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::setting::{SettingError, require};

/// The way the tool travels while it cuts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Direction {
    /// From the tailstock to the chuck.
    #[default]
    TowardsChuck,
    /// From the chuck to the tailstock.
    TowardsTailstock,
}

/// How the control takes X of a wear offset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WearX {
    /// 0.01 moves the tool so that the diameter changes by 0.01 mm.
    Diameter,
    /// 0.01 moves the tool by 0.01 mm: the diameter changes by 0.02 mm.
    Radius,
}

impl WearX {
    /// Change of the diameter for a register value of 1.
    pub(super) fn diameter_per_unit(self) -> f64 {
        match self {
            Self::Diameter => 1.0,
            Self::Radius => 2.0,
        }
    }
}

/// Which digits of a T word choose the geometry offset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum GeometryOffset {
    /// Those of the tool: T0116 takes the geometry of tool 1 and the wear of offset 16.
    ByTool,
    /// Those of the offset: T0116 takes geometry and wear of offset 16.
    ByOffset,
}

/// Sense in which the spindle turns for the cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Spindle {
    /// M03.
    M03,
    /// M04.
    M04,
}

/// How the control holds the spindle at an angle: `M19 R…`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpindleOrientation {
    /// Angle at which the part is probed, degrees.
    #[serde(default)]
    pub angle_deg: f64,
    /// M code that turns to the angle and holds it; 19 by default, fixed on linuxcnc.
    #[serde(default = "nineteen")]
    pub m_code: u32,
    /// M code that lets go, where M05 and M03 do not.
    #[serde(default)]
    pub release_m_code: Option<u32>,
}

fn nineteen() -> u32 {
    19
}

impl SpindleOrientation {
    /// M codes that have another meaning in every program.
    const TAKEN: [u32; 7] = [0, 2, 3, 4, 5, 6, 30];

    pub(super) fn validate(&self) -> Result<(), SettingError> {
        let angle = self.angle_deg;
        let right = "an angle of 0 to below 360 degrees";
        require((0.0..360.0).contains(&angle), "nc.spindle_orientation.angle_deg", angle, right)?;
        let free = |code: u32| code <= 999 && !Self::TAKEN.contains(&code);
        let right = "an M code up to 999 that is not M00, M02 to M06 or M30";
        let code = self.m_code;
        require(free(code), "nc.spindle_orientation.m_code", f64::from(code), right)?;
        let release = self.release_m_code.unwrap_or(nineteen());
        require(free(release), "nc.spindle_orientation.release_m_code", f64::from(release), right)
    }

    /// The angle, or the opposite one.
    pub(super) fn angle(&self, opposite: bool) -> f64 {
        (self.angle_deg + if opposite { 180.0 } else { 0.0 }) % 360.0
    }
}

/// Where tools are changed: position of the tip in the part's coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChangePosition {
    /// X, mm of diameter: clear of everything that stands around the part.
    pub x_mm: f64,
    /// Z, mm.
    pub z_mm: f64,
}

/// Chuck and jaws.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Chuck {
    /// Diameter that the chuck takes up behind Z = 0, mm.
    pub diameter_mm: f64,
    /// How far jaws or a clamp reach beyond Z = 0, mm.
    #[serde(default)]
    pub jaws_to_z_mm: f64,
    /// Diameter that the jaws take up, mm; the chuck's by default.
    #[serde(default)]
    pub jaws_diameter_mm: Option<f64>,
}

/// What stands at the free end of the part.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Tailstock {
    /// Nothing: the space beyond the end face is free.
    #[serde(rename = "none")]
    Absent,
    /// A centre.
    Centre(Centre),
}

/// A centre in the end face, and the quill that holds it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Centre {
    /// Included angle of the point, degrees.
    #[serde(default = "sixty")]
    pub point_deg: f64,
    /// Diameter of the point where it enters the end face, mm.
    pub hole_mm: f64,
    /// Largest diameter of the centre, mm.
    pub body_mm: f64,
    /// Diameter of the quill, mm.
    pub quill_mm: f64,
    /// Distance of the quill from the end face, mm.
    pub quill_from_mm: f64,
}

fn sixty() -> f64 {
    60.0
}

/// A steady rest, or anything else that takes up a length of the part.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Obstacle {
    /// Where it begins, mm.
    pub from_z_mm: f64,
    /// Where it ends, mm.
    pub to_z_mm: f64,
    /// Diameter that it takes up, from the axis outwards, mm.
    pub diameter_mm: f64,
}

/// Where the tip can travel, in the part's coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Travel {
    /// Least and largest X, mm of diameter.
    pub x_mm: (f64, f64),
    /// Least and largest Z, mm.
    pub z_mm: (f64, f64),
}

/// The tool behind its nose, as a box.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Holder {
    /// How far it reaches from the programmed point towards the chuck, mm.
    pub towards_chuck_mm: f64,
    /// How far it reaches towards the tailstock, mm.
    pub towards_tailstock_mm: f64,
    /// Height above the tip where it begins, mm (radial).
    pub above_mm: f64,
}

/// A boring bar behind its nose: what goes into the bore with it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoringBar {
    /// Diameter of the bar, mm.
    pub diameter_mm: f64,
    /// Distance of the programmed point from the bar's axis, mm (f of ISO 5609-1).
    pub tip_mm: f64,
    /// How far it reaches from the programmed point to what holds it, mm.
    pub reach_mm: f64,
    /// How far it reaches beyond the programmed point towards the chuck, mm.
    #[serde(default)]
    pub front_mm: f64,
}

impl BoringBar {
    pub(super) fn validate(&self) -> Result<(), SettingError> {
        for (key, value) in [
            ("nc.boring_bar.diameter_mm", self.diameter_mm),
            ("nc.boring_bar.tip_mm", self.tip_mm),
            ("nc.boring_bar.reach_mm", self.reach_mm),
        ] {
            require(value > 0.0 && value.is_finite(), key, value, "a positive length in mm")?;
        }
        let front = self.front_mm;
        require((0.0..1e3).contains(&front), "nc.boring_bar.front_mm", front, "0 mm or more")
    }
}

impl Obstacle {
    pub(super) fn validate(&self, [from, to, diameter]: [&'static str; 3]) -> Result<(), SettingError> {
        let (begin, end, across) = (self.from_z_mm, self.to_z_mm, self.diameter_mm);
        require(begin.is_finite(), from, begin, "a length in mm")?;
        require(end > begin && end.is_finite(), to, end, "a length above from_z_mm")?;
        require(across > 0.0 && across.is_finite(), diameter, across, "a positive length in mm")
    }
}

impl Centre {
    pub(super) fn validate(&self) -> Result<(), SettingError> {
        let right = "an angle of 20 to 120 degrees";
        let angle = self.point_deg;
        require((20.0..=120.0).contains(&angle), "nc.tailstock.centre.point_deg", angle, right)?;
        let positive = |key, value: f64| {
            require(value > 0.0 && value.is_finite(), key, value, "a positive length in mm")
        };
        positive("nc.tailstock.centre.hole_mm", self.hole_mm)?;
        positive("nc.tailstock.centre.quill_mm", self.quill_mm)?;
        positive("nc.tailstock.centre.quill_from_mm", self.quill_from_mm)?;
        let body = self.body_mm;
        require(body >= self.hole_mm, "nc.tailstock.centre.body_mm", body, "at least hole_mm")
    }
}
