//! The settings of `[machine]` in a job.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::gauge::calibration::HeadPlace;
use crate::machine::{Conditions, MachineSettings};

/// The `[machine]` table of a job.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RunMachine {
    /// File of the machine with its errors, as `study machine` reads it (docs/machine.md), from the
    /// folder of this file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Whether the control compensates the machine's static errors by a table of its own: at every
    /// station the command is less by what they add to the diameter there.
    pub compensate: bool,
    /// Whether the readings of the head are corrected by what the table has of its place: +D·û_y/ℓ
    /// by the calibrated telecentricity, z + û_z; u(û_y) is the budget row "machine geometry".
    pub correct_readings: bool,
    /// File of the machine as the control's table has it: the `machine.json` of `calibrate
    /// machine`, or a file like `file`; that of `file` itself where it is left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table: Option<String>,
    /// Name of the machine; the file's where it is left out. A `machine.json` of another one is
    /// refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Name of the head. A `machine.json` that another head's readings have part in is refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub head: Option<String>,
    /// Temperature of the machine, °C; the file's where it is left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature_c: Option<f64>,
    /// Time since spindle and slides started from cold, minutes; the file's where it is left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub minutes: Option<f64>,
    /// Temperature at which the errors of the table's file were read, °C.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) table_temperature_c: Option<f64>,
    /// Errors of the table's file that move the head along Y and count as zero.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) table_unread: Vec<String>,
    /// A displacement probe on the X slide, as a second head: its readings of every pass stand in
    /// machine_probe.csv. Neither gauge nor controller is given them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) probe: Option<DisplacementProbe>,
    /// What `[machine]` of that file holds, in its place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) stated: Option<MachineSettings>,
    /// What `[machine]` of that file holds, in its place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) table_stated: Option<MachineSettings>,
    /// Where the head of that file stands with its uncertainty, in its place.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) table_head: Vec<StatedPlace>,
}

/// The side of the axis on which a probe touches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ProbeSide {
    /// The tool's, x above 0.
    #[default]
    Tool,
    /// The other, x below 0.
    Opposite,
}

/// A displacement probe on the X slide.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct DisplacementProbe {
    /// The side on which it touches.
    pub side: ProbeSide,
    /// From the X slide's reference to its tip, [x, y, z], mm; the tool's where it is left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probe_mm: Option<[f64; 3]>,
    /// Radius of its ball, mm. 0 ..= 50.
    pub tip_radius_mm: f64,
    /// Standard deviation of a reading of its displacement, µm. 0 ..= 100.
    pub noise_um: f64,
}

impl Default for DisplacementProbe {
    /// The inductive probe of the paper on the lathe as its own measuring machine: .01 µm.
    fn default() -> Self {
        Self { side: ProbeSide::Tool, probe_mm: None, tip_radius_mm: 1.5, noise_um: 0.01 }
    }
}

/// A place of the head as a resolved config states it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StatedPlace {
    /// Middle of the field, mm.
    pub z_mm: f64,
    /// Displacement of the head along Y, towards the camera, µm.
    pub u_y_um: f64,
    /// Its standard uncertainty, µm.
    pub u_u_y_um: f64,
    /// Displacement along the spindle, µm.
    pub u_z_um: f64,
}

impl From<&HeadPlace> for StatedPlace {
    fn from(place: &HeadPlace) -> Self {
        Self {
            z_mm: place.z_mm,
            u_y_um: -1e3 * place.axis_y_mm,
            u_u_y_um: 1e3 * place.u_axis_y_mm,
            u_z_um: 1e3 * place.axial_mm,
        }
    }
}

impl From<&StatedPlace> for HeadPlace {
    fn from(place: &StatedPlace) -> Self {
        Self {
            z_mm: place.z_mm,
            axis_y_mm: -1e-3 * place.u_y_um,
            u_axis_y_mm: 1e-3 * place.u_u_y_um,
            axial_mm: 1e-3 * place.u_z_um,
        }
    }
}

impl RunMachine {
    /// Takes the contents of a machine's file in place of its name; its state counts where this
    /// table has none.
    pub(crate) fn take(&mut self, machine: MachineSettings, state: &Conditions) {
        self.file = None;
        self.stated = Some(machine);
        self.temperature_c = self.temperature_c.or(Some(state.temperature_c));
        self.minutes = self.minutes.or(Some(state.minutes));
    }
}
