//! The config files and their JSON Schemas.

use schemars::{Schema, schema_for};

use crate::gauge::calibration::Conditions;
use crate::job::Job;
use crate::nc::NcSettings;
use crate::studies::calibration::CalibrationPlan;
use crate::studies::deflection::DeflectionConfig;
use crate::studies::factor::FactorConfig;
use crate::studies::optimize::OptimizeConfig;
use crate::studies::reproduce_003::Inputs;

/// A kind of config file.
pub(crate) struct ConfigFile {
    /// Name of its schema's file, before `.schema.json`.
    pub name: &'static str,
    /// Which file it is and which command reads it.
    pub title: &'static str,
    /// Its schema.
    pub schema: Schema,
}

impl ConfigFile {
    /// The schema as a file's text.
    pub(crate) fn text(&self) -> String {
        serde_json::to_string_pretty(&self.schema).unwrap_or_default() + "\n"
    }
}

/// All kinds, jobs first.
pub(crate) fn all() -> Vec<ConfigFile> {
    let of = |name, title, schema| ConfigFile { name, title, schema };
    vec![
        of("job", "A job (`run`, `render`, most studies)", schema_for!(Job)),
        of("calibration", "A calibration (`calibrate`, `study uncertainty`)", schema_for!(CalibrationPlan)),
        of("conditions", "Conditions of a part (`measure --conditions`)", schema_for!(Conditions)),
        of("machine", "A machine (`nc --machine`)", schema_for!(NcSettings)),
        of("optimize", "A choice of cutting data (`optimize`)", schema_for!(OptimizeConfig)),
        of("factor", "A study of single factors (`study factor`)", schema_for!(FactorConfig)),
        of("beam", "A held shaft (`study deflection`)", schema_for!(DeflectionConfig)),
        of("reproduce_003", "A paper's inputs (`reproduce 003 --inputs`)", schema_for!(Inputs)),
    ]
}
