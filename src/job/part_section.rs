//! What a drawing states of a section of a stepped shaft: `[[part.sections]]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::conformity::Tolerance;

/// What the drawing states of a section of a stepped shaft.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PartSection {
    /// A place on the section, mm from the chuck face: on the cylinder or taper of `[shaft]
    /// contour` that is meant.
    pub z_mm: f64,
    /// Its name in reports; left out, its diameter and ends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Its tolerance; without one no verdict is given on it. A taper takes none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<Tolerance>,
    /// Added to the diameter of the drawing: where in its tolerance the section shall lie, mm. Left
    /// out, the middle of the tolerance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub aim_mm: Option<f64>,
    /// Whether it has stations. A cylinder shorter than a station must be set to false (a groove, a
    /// collar): it is cut with the offsets of its neighbours and not judged.
    #[serde(default = "yes")]
    pub measured: bool,
}

fn yes() -> bool {
    true
}
