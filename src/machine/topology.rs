//! How the slides stand on each other.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which slide carries which, from the part to the tool (w: part, b: base, t: tool).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Topology {
    /// w-C'-Z'-b-X-t: the Z slide carries the spindle, the X slide the tool (T-shaped lathes).
    TShaped,
    /// w-C'-b-Z-X-t: the spindle stands, the Z slide carries the X slide (lathes with a carriage).
    Carriage,
}

impl Topology {
    /// The kinematic chain from the work w over the base b to the tool t; a prime: carries the
    /// work.
    pub(crate) fn notation(self) -> &'static str {
        match self {
            Self::TShaped => "w-C'-Z'-b-X-t",
            Self::Carriage => "w-C'-b-Z-X-t",
        }
    }
}
