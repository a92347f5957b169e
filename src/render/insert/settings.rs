//! Settings of a rendered insert.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::render::error::{RenderError, within};
use crate::render::settings::{Esf, Light, Sensor};

/// A back-lit insert and the camera before it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct InsertSettings {
    /// Field and scale.
    pub camera: InsertCamera,
    /// The nose as ground, and where it lies.
    pub nose: InsertNose,
    /// What use has done to it, one table each.
    pub wear: Vec<Wear>,
    /// Specks in the plane of the insert.
    pub dirt: Vec<Dirt>,
    /// How light passes into shadow.
    pub esf: Esf,
    /// Backlight.
    pub light: Light,
    /// Sensor.
    pub sensor: Sensor,
}

/// Field and scale.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct InsertCamera {
    /// Pixels along a row.
    pub columns: u32,
    /// Rows.
    pub rows: u32,
    /// Scale, µm per px.
    pub um_per_px: f64,
}

impl Default for InsertCamera {
    /// The camera of paper 004 (MV-CE060-10UC), magnification 0.9938.
    fn default() -> Self {
        Self { columns: 3072, rows: 2048, um_per_px: 2.415 }
    }
}

/// The nose as ground.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct InsertNose {
    /// Radius, mm.
    pub radius_mm: f64,
    /// Included angle of both edges, degrees.
    pub epsilon_deg: f64,
    /// Direction in which the nose points, degrees: 0 to the right, counter-clockwise as seen.
    pub direction_deg: f64,
    /// Centre of the nose: column and row.
    pub centre_px: [f64; 2],
}

impl Default for InsertNose {
    /// A corner of 60° at the middle of the default field, as a right-hand tool (κ_r 93°) whose +X
    /// is up and +Z to the right points.
    fn default() -> Self {
        Self { radius_mm: 0.4, epsilon_deg: 60.0, direction_deg: 237.0, centre_px: [1100.0, 1400.0] }
    }
}

/// A change of the nose by use; directions as seen, about the nose's centre.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Wear {
    /// Wear that fades towards both edges: depth·cos² over the nose.
    Round {
        /// Depth in the middle of the nose, µm.
        depth_um: f64,
    },
    /// A plane worn across the nose.
    Flat {
        /// Direction of its normal, degrees.
        direction_deg: f64,
        /// Depth below the round nose, µm.
        depth_um: f64,
    },
    /// A dent with round flanks: depth·cos² over its width.
    Dent {
        /// Its middle, degrees.
        direction_deg: f64,
        /// Width, degrees.
        width_deg: f64,
        /// Depth, µm.
        depth_um: f64,
    },
    /// A chip with straight flanks.
    Chip {
        /// Its middle, degrees.
        direction_deg: f64,
        /// Width, degrees.
        width_deg: f64,
        /// Depth, µm.
        depth_um: f64,
    },
    /// Adhering material: a dent outwards.
    BuiltUpEdge {
        /// Its middle, degrees.
        direction_deg: f64,
        /// Width, degrees.
        width_deg: f64,
        /// Height, µm.
        height_um: f64,
    },
}

/// A round speck.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Dirt {
    /// Its middle: column and row.
    pub centre_px: [f64; 2],
    /// Radius, µm.
    pub radius_um: f64,
}

impl InsertSettings {
    /// Checks every value against its range.
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        within("camera.columns", f64::from(self.camera.columns), 64.0, 16384.0)?;
        within("camera.rows", f64::from(self.camera.rows), 64.0, 16384.0)?;
        within("camera.um_per_px", self.camera.um_per_px, 0.01, 1000.0)?;
        within("nose.radius_mm", self.nose.radius_mm, 0.001, 20.0)?;
        within("nose.epsilon_deg", self.nose.epsilon_deg, 20.0, 150.0)?;
        within("nose.direction_deg", self.nose.direction_deg, -360.0, 360.0)?;
        for at in self.nose.centre_px {
            within("nose.centre_px", at, -1e5, 1e5)?;
        }
        self.esf.check()?;
        self.light.check(&self.sensor)?;
        self.sensor.check()?;
        self.sensor.check_plain()?;
        for dirt in &self.dirt {
            within("dirt.radius_um", dirt.radius_um, 0.1, 1e4)?;
        }
        self.wear.iter().try_for_each(|w| w.check(1e3 * self.nose.radius_mm))
    }
}

impl Wear {
    fn check(&self, radius_um: f64) -> Result<(), RenderError> {
        match *self {
            Self::Round { depth_um } | Self::Flat { depth_um, .. } => {
                within("wear.depth_um", depth_um, 0.0, 0.5 * radius_um)
            }
            Self::Dent { width_deg, depth_um, .. } | Self::Chip { width_deg, depth_um, .. } => {
                within("wear.width_deg", width_deg, 0.1, 120.0)?;
                within("wear.depth_um", depth_um, 0.0, 0.5 * radius_um)
            }
            Self::BuiltUpEdge { width_deg, height_um, .. } => {
                within("wear.width_deg", width_deg, 0.1, 120.0)?;
                within("wear.height_um", height_um, 0.0, 0.5 * radius_um)
            }
        }
    }
}
