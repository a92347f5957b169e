//! The machine that the offsets go to: the `[nc]` table.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::nc::{Dialect, NcSettings};

/// Where offsets go: the control whose increments they are rounded to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NcJob {
    /// The control.
    pub dialect: Dialect,
    /// What its programs need to know of the machine.
    #[serde(default)]
    pub machine: NcSettings,
}
