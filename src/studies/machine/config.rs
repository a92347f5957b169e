//! What `study machine` reads: a machine, its state, the part and the heads.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::machine::response::{Part, TwoSided};
use crate::machine::{Conditions, MachineSettings};
use crate::setting::{SettingError, positive, require, within};

/// A machine and what is asked of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MachineStudyConfig {
    /// Name, for reports.
    #[serde(default)]
    pub name: String,
    /// The chain, its levers and its errors.
    pub machine: MachineSettings,
    /// The state of the machine: directions, spindle angle, temperature, time.
    #[serde(default)]
    pub conditions: Conditions,
    /// The part that is turned and measured.
    pub part: StudyPart,
    /// Heads that see both edges, beside a probe; two where the list is left out.
    #[serde(default = "heads")]
    pub heads: Vec<StudyHead>,
    /// The points of the map.
    #[serde(default)]
    pub map: MapPoints,
    /// The spiral on which a face is probed.
    #[serde(default)]
    pub spiral: StudySpiral,
}

/// An Archimedean spiral on a face: a probe along X while the spindle turns.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct StudySpiral {
    /// Radius of the face, mm; the part's where it is left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius_mm: Option<f64>,
    /// Position of Z at which the face is turned, mm; the upper end of the travel where it is left
    /// out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub z_mm: Option<f64>,
    /// Growth of the radius a turn, mm; 1, or a third of the radius where that is less, where it is
    /// left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pitch_mm: Option<f64>,
    /// Points a turn. Must lie between 3 and 360.
    pub points_per_turn: usize,
}

impl Default for StudySpiral {
    /// The paper's: 1 mm and ten points a turn.
    fn default() -> Self {
        Self { radius_mm: None, z_mm: None, pitch_mm: None, points_per_turn: 10 }
    }
}

impl StudySpiral {
    /// The pitch on a face of a radius, mm.
    pub(super) fn pitch_mm(&self, radius_mm: f64) -> f64 {
        self.pitch_mm.unwrap_or_else(|| (radius_mm / 3.0).min(1.0))
    }

    fn validate(&self, config: &MachineStudyConfig) -> Result<(), SettingError> {
        let ([_, x_to], [z_from, z_to]) = (config.machine.x_travel_mm, config.machine.z_travel_mm);
        let radius = self.radius_mm.unwrap_or(config.part.radius_mm());
        let right = format!("above 0 and at most {x_to} mm, the end of machine.x_travel_mm");
        require(radius > 0.0 && radius <= x_to, "spiral.radius_mm", radius, &right)?;
        let z = self.z_mm.unwrap_or(z_to);
        within("spiral.z_mm", z, z_from, z_to, &format!("in machine.z_travel_mm, {z_from} to {z_to} mm"))?;
        let right = format!("above 0.01 and at most a third of the radius, {}", radius / 3.0);
        let pitch = self.pitch_mm(radius);
        within("spiral.pitch_mm", pitch, 0.01, radius / 3.0, &right)?;
        let points = "spiral.points_per_turn";
        require(
            (3..=360).contains(&self.points_per_turn),
            points,
            self.points_per_turn,
            "between 3 and 360",
        )?;
        let count = radius / pitch * self.points_per_turn as f64;
        let right = "few enough for at most 100000 points on the spiral";
        require(count <= 1e5, points, self.points_per_turn, right)
    }
}

/// A cylinder or a cone between the ends of the travel of Z.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StudyPart {
    /// Diameter, mm; half of it must lie in the travel of X.
    pub diameter_mm: f64,
    /// Growth of the diameter with z (0.1: 0.1 mm a mm); the diameter above is meant at every z.
    #[serde(default)]
    pub taper: f64,
}

/// A head that sees both edges, or a pair of heads with an edge each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StudyHead {
    /// Name, for tables and charts.
    pub name: String,
    /// From the axis of rotation to the entrance pupil, mm; `inf` for a lens that is telecentric
    /// without remainder. A telecentricity of .03° at 24.4 mm off the optical axis is 46 600 mm.
    pub pupil_mm: f64,
    /// Growth of the scale across the image, 1/mm (keystone).
    #[serde(default)]
    pub keystone_per_mm: f64,
    /// How far the upper edge's head stands from the lower edge's along y, mm.
    #[serde(default)]
    pub pair_y_mm: f64,
    /// How far the upper edge's head stands from the lower edge's along z, mm.
    #[serde(default)]
    pub pair_z_mm: f64,
}

/// Points of the map along each axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct MapPoints {
    /// Positions of X. Must lie between 2 and 1001.
    pub x_points: usize,
    /// Positions of Z. Must lie between 2 and 1001.
    pub z_points: usize,
}

impl Default for MapPoints {
    /// The paper's raster of 51 by 51.
    fn default() -> Self {
        Self { x_points: 51, z_points: 51 }
    }
}

/// Heads where the config names none: a telecentric lens with .03° left at 24.4 mm, and one that is
/// not telecentric.
fn heads() -> Vec<StudyHead> {
    let head = |name: &str, pupil_mm: f64| StudyHead {
        name: name.to_owned(),
        pupil_mm,
        keystone_per_mm: 0.0,
        pair_y_mm: 0.0,
        pair_z_mm: 0.0,
    };
    vec![head("telecentric", 46_600.0), head("entocentric", 300.0)]
}

impl StudyHead {
    /// The head's optics.
    pub(crate) fn optics(&self) -> TwoSided {
        TwoSided {
            pupil_mm: self.pupil_mm,
            keystone_per_mm: self.keystone_per_mm,
            pair_mm: [self.pair_y_mm, self.pair_z_mm],
        }
    }

    fn validate(&self, key: &str, radius_mm: f64) -> Result<(), SettingError> {
        let taken = ["", "cut", "probe", "midline"];
        let right = "a name of its own: not empty, nor cut, probe or midline, which tables have already";
        require(!taken.contains(&self.name.as_str()), &format!("{key}.name"), &self.name, right)?;
        let right = format!("above {}, twice the part's radius (inf: telecentric)", 2.0 * radius_mm);
        require(self.pupil_mm > 2.0 * radius_mm, &format!("{key}.pupil_mm"), self.pupil_mm, &right)?;
        let right = "within ±0.01 1/mm";
        within(&format!("{key}.keystone_per_mm"), self.keystone_per_mm, -0.01, 0.01, right)?;
        for (name, value) in [("pair_y_mm", self.pair_y_mm), ("pair_z_mm", self.pair_z_mm)] {
            within(&format!("{key}.{name}"), value, -1000.0, 1000.0, "within ±1000 mm")?;
        }
        Ok(())
    }
}

impl StudyPart {
    /// The part at any z.
    pub(crate) fn part(&self) -> Part {
        Part { diameter_mm: self.diameter_mm, taper: self.taper }
    }

    /// Its radius, mm.
    pub(crate) fn radius_mm(&self) -> f64 {
        0.5 * self.diameter_mm
    }
}

impl MachineStudyConfig {
    /// Checks what stands beside `[machine]`, whose own check is
    /// [`MachineSettings::motion`].
    ///
    /// # Errors
    /// The first value out of range.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        self.conditions.validate()?;
        positive("part.diameter_mm", self.part.diameter_mm)?;
        let radius = self.part.radius_mm();
        let [from, to] = self.machine.x_travel_mm;
        let right = format!("such that its radius lies in machine.x_travel_mm, {from} to {to} mm");
        require((from..=to).contains(&radius), "part.diameter_mm", self.part.diameter_mm, &right)?;
        within("part.taper", self.part.taper, -2.0, 2.0, "within ±2 (mm of diameter a mm of z)")?;
        let tip = self.machine.tip_above_axis_mm;
        let right = "closer to the axis than half the part's radius";
        require(tip.abs() <= 0.5 * radius, "machine.tip_above_axis_mm", tip, right)?;
        for (key, count) in [("map.x_points", self.map.x_points), ("map.z_points", self.map.z_points)] {
            require((2..=1001).contains(&count), key, count, "between 2 and 1001")?;
        }
        self.spiral.validate(self)?;
        for (k, head) in self.heads.iter().enumerate() {
            let is_new = self.heads[..k].iter().all(|before| before.name != head.name);
            require(is_new, &format!("heads[{k}].name"), &head.name, "another name than the heads before")?;
        }
        let mut heads = self.heads.iter().enumerate();
        heads.try_for_each(|(k, head)| head.validate(&format!("heads[{k}]"), radius))
    }
}
