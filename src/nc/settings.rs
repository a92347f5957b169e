//! Data of the machine that a program needs: the `[nc.machine]` table.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::machine::{
    BoringBar, ChangePosition, Chuck, GeometryOffset, Holder, Obstacle, Spindle, SpindleOrientation,
    Tailstock, Travel, WearX,
};
use super::probe_settings::NcProbe;
use super::scan_settings::NcScan;
use crate::setting::{SettingError, require};

/// Measuring after the cut, by an M code that leaves its results in macro variables.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Remeasure {
    /// The M code that scans the part.
    pub m_code: u32,
    /// Variable with the smallest diameter found, mm.
    pub smallest_variable: u32,
    /// Variable with the largest diameter found, mm.
    pub largest_variable: u32,
}

/// What a program needs to know of the machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct NcSettings {
    /// Program number, 1-9999.
    pub program: u32,
    /// Tool number, 1-99.
    pub tool: u32,
    /// Wear offset that belongs to these programs alone, 1-99.
    pub wear_offset: u32,
    /// Number of the part: with the pass it makes a program run once only.
    pub part_number: u32,
    /// Clear of the stock's diameter on approach and retract, mm of diameter.
    pub clearance_mm: f64,
    /// Path beyond the end face of the part, in the air, mm; at most 0.5 mm of it where a centre
    /// stands there.
    pub lead_in_mm: f64,
    /// Not used any more: the path ends at `least_z_mm`. Read so that older files stay valid.
    pub lead_out_mm: f64,
    /// Least Z that the nose of the tool may reach, mm from the chuck face: what lies below stays
    /// uncut.
    pub least_z_mm: f64,
    /// Spindle speed limit under constant cutting speed, 1/min.
    pub speed_limit_per_min: u32,
    /// Least number of knots.
    pub least_knots: usize,
    /// Knots are added until the path is within this of the offsets at every station, mm of
    /// diameter.
    pub knot_tolerance_mm: f64,
    /// Largest correction at a knot, mm of diameter.
    pub correction_limit_mm: f64,
    /// Re-measure after the cut and raise an alarm outside the limits.
    pub remeasure: Option<Remeasure>,
    /// A touch probe in the tool carrier: the part is probed after its last pass, and `--form
    /// probing` measures before it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probe: Option<NcProbe>,
    /// How the carriage takes the gauge head along the part: `nc --scan`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scan: Option<NcScan>,
    /// How the control takes X of a wear offset; no default for fanuc and gsk.
    pub wear_x: Option<WearX>,
    /// Which digits of a T word choose the geometry offset; no default for fanuc and gsk.
    pub geometry_offset: Option<GeometryOffset>,
    /// Sense of the spindle; no default for fanuc and gsk, M03 for linuxcnc.
    pub spindle: Option<Spindle>,
    /// Angle at which the spindle is held while the part is probed; it is not fixed where this is
    /// not stated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spindle_orientation: Option<SpindleOrientation>,
    /// Where tools are changed: the reference point (G28) of fanuc and gsk as seen from the part, a
    /// place to go to for linuxcnc.
    pub change_position: Option<ChangePosition>,
    /// Nose radius of the tool, mm; 0.8 where it is not stated.
    pub nose_radius_mm: Option<f64>,
    /// The tool behind its nose; only the nose is replayed where it is not stated.
    pub holder: Option<Holder>,
    /// The tool where it is a boring bar: programs for bores need it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub boring_bar: Option<BoringBar>,
    /// Chuck and jaws; nothing may move behind Z = 0 where they are not stated.
    pub chuck: Option<Chuck>,
    /// `"none"` or a centre; a large centre is assumed where it is not stated.
    pub tailstock: Option<Tailstock>,
    /// Steady rests; those of the run's `process.support` where they are not stated.
    pub steady_rests: Option<Vec<Obstacle>>,
    /// The gauge head where it is parked.
    pub gauge_head: Option<Obstacle>,
    /// Travel limits of the tip.
    pub travel: Option<Travel>,
}

impl Default for NcSettings {
    fn default() -> Self {
        Self {
            program: 8001,
            tool: 1,
            wear_offset: 16,
            part_number: 1,
            clearance_mm: 2.0,
            lead_in_mm: 2.0,
            lead_out_mm: 1.0,
            least_z_mm: 0.5,
            speed_limit_per_min: 2000,
            least_knots: 21,
            knot_tolerance_mm: 0.0002,
            correction_limit_mm: 0.3,
            remeasure: None,
            probe: None,
            scan: None,
            wear_x: None,
            geometry_offset: None,
            spindle: None,
            spindle_orientation: None,
            change_position: None,
            nose_radius_mm: None,
            holder: None,
            boring_bar: None,
            chuck: None,
            tailstock: None,
            steady_rests: None,
            gauge_head: None,
            travel: None,
        }
    }
}

impl NcSettings {
    /// Checks the table.
    ///
    /// # Errors
    /// [`SettingError`] names the key.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        let number = |key, value: u32, most: u32, right| {
            require((1..=most).contains(&value), key, f64::from(value), right)
        };
        number("nc.program", self.program, 9999, "a number of 1 to 9999")?;
        number("nc.tool", self.tool, 99, "a number of 1 to 99")?;
        number("nc.wear_offset", self.wear_offset, 99, "a number of 1 to 99")?;
        number("nc.part_number", self.part_number, 999_999, "a number of 1 to 999999")?;
        number("nc.speed_limit_per_min", self.speed_limit_per_min, 20_000, "a speed of 1 to 20000 1/min")?;
        let lengths = [
            ("nc.clearance_mm", self.clearance_mm),
            ("nc.lead_in_mm", self.lead_in_mm),
            ("nc.knot_tolerance_mm", self.knot_tolerance_mm),
            ("nc.correction_limit_mm", self.correction_limit_mm),
        ];
        for (key, value) in lengths {
            require(value > 0.0 && value.is_finite(), key, value, "a positive length in mm")?;
        }
        for (key, value) in [("nc.lead_out_mm", self.lead_out_mm), ("nc.least_z_mm", self.least_z_mm)] {
            require(value >= 0.0 && value.is_finite(), key, value, "a length of 0 mm or more")?;
        }
        self.validate_surroundings()?;
        self.probe.map_or(Ok(()), |probe| probe.validate(self.tool, self.correction_limit_mm))?;
        self.scan.map_or(Ok(()), |scan| scan.validate(self.speed_limit_per_min))?;
        let knots = self.least_knots;
        require((2..=1000).contains(&knots), "nc.least_knots", knots as f64, "a number of 2 to 1000")
    }
}
