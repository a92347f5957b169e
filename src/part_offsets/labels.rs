//! Names of part, tool and insert.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What is in the machine, by the names that its people use.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Labels {
    /// Identity of the part that was measured; empty where none was given.
    pub part: String,
    /// Tool that cuts the next part; empty where none was given.
    pub tool: String,
    /// Insert that cuts the next part; empty where none was given.
    pub insert: String,
}
