//! `machine.json`: the errors of a machine as they were identified.
//!
//! The tables of [`IdentifiedMachine::machine`] are what a control's compensation takes; the rest
//! is what they are worth: uncertainty, covariance, what is inseparable, where the readings end.
//! Tables end where the readings do, and so do the travels: beyond them a run is refused.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::iso230_2::Positioning;
use super::spindle_readings::SpindleRow;
use crate::machine::table_file::Columns;
use crate::machine::{ErrorName, MachineSettings};
use crate::setting::SettingError;

/// What the file is, with its version.
pub(crate) const FORMAT: &str = "shadowgauge machine errors 1";
/// How far a lever may differ from the one with which the errors were identified, mm: 50 µrad then
/// act on 0.5 nm.
const LEVER_MM: f64 = 0.01;

/// A machine with its identified errors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct IdentifiedMachine {
    /// [`FORMAT`].
    pub format: String,
    /// Name of the machine.
    pub name: String,
    /// Name of the head, where its own readings took part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub head: Option<String>,
    /// Temperature of the machine while it was read, °C.
    pub temperature_c: f64,
    /// Model of the compensation: structured or splines.
    pub model: String,
    /// Positions over which the errors are identified, mm.
    pub range: IdentifiedRange,
    /// Chain, levers, travels (the range) and the errors as tables.
    pub machine: MachineSettings,
    /// The errors with their uncertainties.
    pub errors: Vec<IdentifiedError>,
    /// Errors that count as zero.
    pub taken_as_zero: Vec<String>,
    /// Unknowns, rank and determined combinations.
    pub rank: IdentifiedRank,
    /// Models with their held-out errors.
    pub models: Vec<ModelRow>,
    /// √ of the reduced χ² of all readings; above 1 the uncertainties are widened by it.
    pub birge_ratio: f64,
    /// The sets of readings.
    pub sets: Vec<SetRow>,
    /// ISO 230-2 of the sets that were read more than once a position.
    pub positioning: Vec<PositioningRow>,
    /// Error motion of the spindle, EXC.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub spindle: Vec<SpindleRow>,
    /// The unknowns of the errors.
    pub unknowns: Vec<UnknownRow>,
    /// Lower triangle of their covariance, row by row, in products of their units.
    pub covariance: Vec<Vec<f64>>,
}

/// Positions over which the errors are identified.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct IdentifiedRange {
    /// Of X, mm.
    pub x_mm: [f64; 2],
    /// Of Z, mm.
    pub z_mm: [f64; 2],
}

/// An identified error, µm or µrad.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct IdentifiedError {
    /// Name of ISO 230-1.
    pub error: String,
    /// What it is.
    pub meaning: String,
    /// µm or µrad.
    pub unit: String,
    /// Where it is zero by convention.
    pub datum: String,
    /// Positions of its slide, mm; none of an orientation.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub position_mm: Vec<f64>,
    /// Values, where the positions grow.
    pub value: Vec<f64>,
    /// Values where they fall, where both directions were read.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub backward: Vec<f64>,
    /// Standard uncertainties.
    pub u: Vec<f64>,
}

/// Rank of the readings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct IdentifiedRank {
    /// Number of unknowns, those of the sets among them.
    pub unknowns: usize,
    /// Combinations of which the readings hold anything.
    pub rank: usize,
    /// Combinations of which they hold more than the class of the machine.
    pub determined: usize,
    /// What cannot be separated, in words.
    pub inseparable: Vec<String>,
}

/// A model of the compensation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ModelRow {
    /// structured or splines.
    pub model: String,
    /// Error on turned parts that took no part, each left out in turn, rms, µm, the readings' own
    /// scatter in it; none without two cylinders or two faces.
    pub held_out_um: Option<f64>,
    /// Error at positions that took no part, of all its readings by their u, rms.
    pub held_out_by_u: f64,
    /// Whether it is written.
    pub is_chosen: bool,
}

/// A set of readings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SetRow {
    /// Its file, or what was simulated.
    pub set: String,
    /// What took them.
    pub instrument: String,
    /// What the readings are referred to.
    pub datum: String,
    /// Number of readings.
    pub readings: usize,
    /// Residuals by their u, rms; none where the model does not take it.
    pub residual_by_u: Option<f64>,
}

/// ISO 230-2 of a set, µm or µrad.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PositioningRow {
    /// Its file, or what was simulated.
    pub set: String,
    /// What was read.
    pub error: String,
    /// µm or µrad.
    pub unit: String,
    /// The parameters.
    #[serde(flatten)]
    pub parameters: Positioning,
}

/// An unknown of the errors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct UnknownRow {
    /// Error and part of it: EXZ shape 3.
    pub name: String,
    /// µm or µrad.
    pub unit: String,
    /// Value.
    pub value: f64,
    /// Standard uncertainty.
    pub u: f64,
}

/// Which machine and head a file is asked for.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(crate) struct MachineIdentity {
    /// Name of the machine.
    pub machine: Option<String>,
    /// Name of the head.
    pub head: Option<String>,
}

impl IdentifiedMachine {
    /// Reads a file's text.
    ///
    /// # Errors
    /// Text that is no such file, one of another version, errors that cannot be right: in words.
    pub(crate) fn read(text: &str) -> Result<Self, String> {
        let value: serde_json::Value = serde_json::from_str(text)
            .map_err(|e| format!("is no machine.json of calibrate machine: {e}"))?;
        let format = value.get("format").and_then(serde_json::Value::as_str).unwrap_or("none");
        if format != FORMAT {
            return Err(format!(
                "its format is '{format}', not '{FORMAT}': is it the machine.json that calibrate machine wrote?"
            ));
        }
        let found: Self =
            serde_json::from_value(value).map_err(|e| format!("is no complete machine.json: {e}"))?;
        found.machine.motion().map_err(|e| e.to_string())?;
        Ok(found)
    }

    /// The same with the spindle's error motion, whose table goes into the machine's.
    ///
    /// # Errors
    /// A table that cannot be right.
    pub(crate) fn with_spindle(mut self, found: SpindleRow) -> Result<Self, SettingError> {
        let columns = Columns {
            position: found.angle_deg.clone(),
            forward: found.motion_um.clone(),
            backward: Vec::new(),
        };
        self.machine.errors.all_mut()[ErrorName::Exc as usize].fill(columns);
        self.machine.motion()?;
        self.taken_as_zero.retain(|code| *code != ErrorName::Exc.code());
        self.spindle.push(found);
        Ok(self)
    }

    /// Whether it is of a machine with these levers.
    ///
    /// # Errors
    /// What differs, in words.
    pub(crate) fn fits(&self, of: &MachineIdentity, machine: &MachineSettings) -> Result<(), String> {
        let names = [("machine", Some(&self.name), &of.machine), ("head", self.head.as_ref(), &of.head)];
        for (what, own, other) in names {
            if let (Some(own), Some(other)) = (own, other)
                && own != other
            {
                return Err(format!("was identified on the {what} '{own}', not on '{other}'"));
            }
        }
        if self.machine.chain != machine.chain {
            let (own, other) = (self.machine.chain.notation(), machine.chain.notation());
            return Err(format!("was identified on another machine: its chain is {own}, not {other}"));
        }
        let own = &self.machine;
        let mut levers = vec![
            ("tool_mm", own.tool_mm, machine.tool_mm),
            ("carriage_mm", own.carriage_mm, machine.carriage_mm),
        ];
        if self.head.is_some() {
            levers.push(("head_mm", own.head_mm, machine.head_mm));
        }
        for (key, own, other) in levers {
            if own.iter().zip(&other).any(|(a, b)| (a - b).abs() > LEVER_MM) {
                return Err(format!(
                    "was identified with {key} = {own:?}, the machine has {other:?}: angles act by other levers, identify again"
                ));
            }
        }
        Ok(())
    }
}
