//! `[[readings]]`: one instrument's readings, and what each kind of them needs.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::instrument::Instrument;
use crate::setting::{SettingError, positive, require, within};

/// What a config has beside a set.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beside {
    /// Whether readings are simulated where a set names no file.
    pub simulates: bool,
    /// Whether the head is named.
    pub has_head: bool,
}

/// Readings of one instrument.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ReadingSet {
    /// What took them.
    pub instrument: Instrument,
    /// A CSV file beside the config: axis, position_mm, direction, run, error, value, unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Standard uncertainty of one reading of a length, random from reading to reading, µm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_um: Option<f64>,
    /// Standard uncertainty of one reading of an angle, µrad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_urad: Option<f64>,
    /// From the slide's reference to the point on it whose shift is read, [x, y, z], mm: needed for
    /// lengths of a laser and a straightedge.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub line_mm: Option<[f64; 3]>,
    /// Radius of the cylinder, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius_mm: Option<f64>,
    /// Position of Z at which the face was turned, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub face_z_mm: Option<f64>,
    /// Where the turned part was read; elsewhere where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub read: Option<ReadWhere>,
    /// From the X slide's reference to the probe's tip, mm; the tool's where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probe_mm: Option<[f64; 3]>,
    /// What the readings of a part are referred to; the axis of rotation where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub datum: Option<Datum>,
    /// The part whose midline was read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<MidlinePart>,
    /// Where simulated readings are taken.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plan: Option<ReadingPlan>,
}

/// Where a turned part was read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ReadWhere {
    /// On another machine, free of this one's errors.
    #[default]
    Elsewhere,
    /// On this machine by a probe on the tool's side of the axis.
    SameSide,
    /// By a probe on this machine beyond the axis.
    OppositeSide,
}

/// What readings are referred to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Datum {
    /// The axis of rotation: a mean value is free, a cone counts.
    #[default]
    Axis,
    /// A line through the readings: mean value and slope are free.
    Line,
}

/// The part whose midline was read: a bar of uniform section from the chuck's face.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MidlinePart {
    /// Diameter, mm.
    pub diameter_mm: f64,
    /// From the chuck's face to the free end or the tailstock's centre, mm.
    pub length_mm: f64,
    /// How it is held.
    pub held: Held,
    /// Cosine of the angle from +X to gravity: -1 where X points up, 0 where it lies level.
    pub gravity_x: f64,
    /// Young's modulus, N/mm².
    #[serde(default = "steel_modulus")]
    pub youngs_modulus_n_per_mm2: f64,
    /// Density, kg/m³.
    #[serde(default = "steel_density")]
    pub density_kg_per_m3: f64,
    /// Relative standard uncertainty of the computed sag (modulus, ends, section).
    #[serde(default = "sag_u")]
    pub sag_u_relative: f64,
    /// Standard uncertainty of the tailstock's place across the axis, µm.
    #[serde(default = "tailstock_u_um")]
    pub tailstock_u_um: f64,
}

/// How a part is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Held {
    /// In the chuck alone.
    Overhung,
    /// In the chuck, with a tailstock's centre.
    ChuckAndTailstock,
    /// Between two centres.
    Centres,
}

/// Where simulated readings are taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ReadingPlan {
    /// First position, mm.
    pub from_mm: f64,
    /// Last position, mm.
    pub to_mm: f64,
    /// Number of positions. Must lie between 2 and 1001.
    pub positions: usize,
    /// Runs in each direction. Must lie between 1 and 100.
    #[serde(default = "one")]
    pub runs: u32,
    /// Whether every run is also made back.
    #[serde(default)]
    pub both_directions: bool,
    /// What is read: names of errors, `radius`, `height`, `midline`, `slope`.
    pub quantities: Vec<String>,
}

fn one() -> u32 {
    1
}

fn steel_modulus() -> f64 {
    210_000.0
}

fn steel_density() -> f64 {
    7850.0
}

/// Modulus of steels within 3 %, the diameter's fourth power, how stiff an end is.
fn sag_u() -> f64 {
    0.05
}

/// Alignment of a tailstock after ISO 13041-1, as a standard deviation.
fn tailstock_u_um() -> f64 {
    20.0
}

impl ReadingSet {
    /// Whether a set has what its instrument needs.
    ///
    /// # Errors
    /// The first value that is missing or cannot be right.
    pub(super) fn check(&self, key: &str, beside: Beside) -> Result<(), SettingError> {
        let at = |name: &str| format!("{key}.{name}");
        for (name, u) in [("u_um", self.u_um), ("u_urad", self.u_urad)] {
            u.map_or(Ok(()), |u| positive(&at(name), u))?;
        }
        if self.file.is_none() && (!beside.simulates || self.plan.is_none()) {
            let why = "names the CSV file of the readings; without one they are simulated by [simulate] at the set's plan";
            return Err(SettingError::at(at("file"), why));
        }
        self.plan.as_ref().map_or(Ok(()), |plan| plan.check(&at("plan")))?;
        let missing = |name: &str, why: &str| Err(SettingError::at(at(name), why));
        match self.instrument {
            Instrument::Cylinder if self.radius_mm.is_none() => {
                missing("radius_mm", "the cylinder's radius, mm: where X stood while it was turned")
            }
            Instrument::Face if self.face_z_mm.is_none() => {
                missing("face_z_mm", "where Z stood while the face was turned, mm")
            }
            Instrument::Midline if self.part.is_none() => {
                missing("part", "diameter, length and holding of the part: its sag is in the midline")
            }
            Instrument::Midline if !beside.has_head => Err(SettingError::at(
                "head",
                "the head whose midline was read: its levers are in the readings",
            )),
            Instrument::Straightedge if self.line_mm.is_none() => {
                missing("line_mm", "the probe's tip from the slide's reference, mm: angles act by it")
            }
            _ => self.part.map_or(Ok(()), |part| part.check(&at("part"))),
        }
    }
}

impl MidlinePart {
    fn check(&self, key: &str) -> Result<(), SettingError> {
        let positives = [
            ("diameter_mm", self.diameter_mm),
            ("length_mm", self.length_mm),
            ("youngs_modulus_n_per_mm2", self.youngs_modulus_n_per_mm2),
            ("density_kg_per_m3", self.density_kg_per_m3),
            ("sag_u_relative", self.sag_u_relative),
            ("tailstock_u_um", self.tailstock_u_um),
        ];
        positives.into_iter().try_for_each(|(name, value)| positive(&format!("{key}.{name}"), value))?;
        let right = "a cosine: -1 where X points up, 1 down, 0 level";
        within(&format!("{key}.gravity_x"), self.gravity_x, -1.0, 1.0, right)
    }
}

impl ReadingPlan {
    fn check(&self, key: &str) -> Result<(), SettingError> {
        let right = format!("above from_mm = {}", self.from_mm);
        require(self.to_mm > self.from_mm, &format!("{key}.to_mm"), self.to_mm, &right)?;
        let positions = format!("{key}.positions");
        require((2..=1001).contains(&self.positions), &positions, self.positions, "between 2 and 1001")?;
        require((1..=100).contains(&self.runs), &format!("{key}.runs"), self.runs, "between 1 and 100")?;
        let quantities = format!("{key}.quantities");
        require(!self.quantities.is_empty(), &quantities, "[]", "what is read, as [\"ezz\"]")
    }
}
