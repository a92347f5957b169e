//! What `calibrate machine` reads: the geometry of a machine, which errors are sought, the sets of
//! readings.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::reading_set::{Beside, ReadingSet};
use super::spindle_readings::SpindleSet;
use crate::machine::settings::Errors;
use crate::machine::{ErrorName, MachineSettings};
use crate::setting::{SettingError, positive, require, within};

/// A machine whose errors are sought.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct IdentificationConfig {
    /// Name of the machine, as its other files have it.
    pub name: String,
    /// Name of the head, where readings of a midline are its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub head: Option<String>,
    /// Temperature of the machine while it was read, °C. Must be between -20 and 80.
    #[serde(default = "reference")]
    pub temperature_c: f64,
    /// The errors that are sought, by their names of ISO 230-1; all others count as zero.
    pub identify: Vec<String>,
    /// The chain, its levers and travels; no errors.
    pub machine: MachineSettings,
    /// The readings.
    pub readings: Vec<ReadingSet>,
    /// Turns of an artefact on the spindle, from which EXC is separated.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub spindle: Vec<SpindleSet>,
    /// What the class of the machine gives before any reading.
    #[serde(default)]
    pub prior: Prior,
    /// Which model of the compensation is written.
    #[serde(default)]
    pub model: ModelChoice,
    /// A machine whose readings are simulated where a set names no file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulate: Option<Simulate>,
}

/// A machine whose readings are simulated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Simulate {
    /// File of the machine with its errors, as `study machine` reads it, beside this file.
    pub machine: String,
    /// Seed of the readings' noise.
    #[serde(default)]
    pub seed: u64,
}

/// How the model of the compensation is chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ModelChoice {
    /// That with the lesser held-out error on turned parts.
    #[default]
    HeldOut,
    /// The errors through the kinematic chain.
    Structured,
    /// A sum of functions of x and of z for each direction of the tool.
    Splines,
}

/// Standard deviations of what a machine of the class has.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Prior {
    /// Of lengths, µm. Must be above 0.
    pub length_um: f64,
    /// Of angles, µrad. Must be above 0.
    pub angle_urad: f64,
}

impl Default for Prior {
    /// What acceptance tests allow lathes of ordinary accuracy over half a metre (ISO 13041-4).
    fn default() -> Self {
        Self { length_um: 10.0, angle_urad: 50.0 }
    }
}

fn reference() -> f64 {
    20.0
}

impl IdentificationConfig {
    /// The errors that are sought.
    ///
    /// # Errors
    /// A name that is none of a slide's errors nor of the orientations, or stands twice; geometry
    /// that cannot be right or has errors of its own; sets that lack what their kind needs.
    pub(crate) fn check(&self) -> Result<Vec<ErrorName>, SettingError> {
        require(!self.name.trim().is_empty(), "name", "empty", "the machine's name, as in its other files")?;
        within("temperature_c", self.temperature_c, -20.0, 80.0, "between -20 and 80 °C")?;
        positive("prior.length_um", self.prior.length_um)?;
        positive("prior.angle_urad", self.prior.angle_urad)?;
        let bare = MachineSettings {
            errors: Errors::default(),
            a0c_urad: 0.0,
            b0c_urad: 0.0,
            b0x_urad: 0.0,
            ..self.machine.clone()
        };
        if bare != self.machine {
            let why = "an identification takes the geometry alone: leave machine.errors, a0c_urad, b0c_urad and b0x_urad out, they are what is sought";
            return Err(SettingError::at("machine.errors", why));
        }
        bare.motion()?;
        require(!self.readings.is_empty(), "readings", "none", "at least one set of readings")?;
        let beside = Beside { simulates: self.simulate.is_some(), has_head: self.head.is_some() };
        for (k, set) in self.readings.iter().enumerate() {
            set.check(&format!("readings[{k}]"), beside)?;
        }
        let right = "at most one: EXC is identified by one separation";
        require(self.spindle.len() <= 1, "spindle", format!("{} sets", self.spindle.len()), right)?;
        self.sought()
    }

    fn sought(&self) -> Result<Vec<ErrorName>, SettingError> {
        require(!self.identify.is_empty(), "identify", "[]", "at least one error, as \"exz\"")?;
        let mut found: Vec<ErrorName> = Vec::new();
        for (k, word) in self.identify.iter().enumerate() {
            let key = format!("identify[{k}]");
            let name = ErrorName::ALL.into_iter().find(|name| name.code().eq_ignore_ascii_case(word));
            let right = "one of the 12 errors of X and Z, b0x, a0c or b0c (the spindle's error motion is separated by reversals: [[spindle]])";
            let usable = name.filter(|name| !(12..18).contains(&(*name as usize)));
            let Some(name) = usable else { return Err(SettingError::of(key, word, right)) };
            require(!found.contains(&name), &key, word, "named once")?;
            found.push(name);
        }
        found.sort_by_key(|name| *name as usize);
        Ok(found)
    }
}
