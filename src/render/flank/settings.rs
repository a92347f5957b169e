//! Settings of a rendered flank.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::render::error::{RenderError, within};

/// A front-lit flank and the camera before it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct FlankScene {
    /// Pixels along a row.
    pub columns: u32,
    /// Rows.
    pub rows: u32,
    /// Scale, µm per px.
    pub um_per_px: f64,
    /// Standard deviation of the blur, px.
    pub blur_px: f64,
    /// Standard deviation of the temporal noise, counts of 255.
    pub noise_counts: f64,
    /// Where the edge lies.
    pub edge: FlankEdge,
    /// What is worn.
    pub wear: FlankWear,
    /// How flank and land look.
    pub surface: FlankSurface,
}

/// Pose of the cutting edge.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct FlankEdge {
    /// The corner: column and row.
    pub corner_px: [f64; 2],
    /// Direction in which the edge leaves the corner, degrees: 0 to the right, counter-clockwise as
    /// seen. The flank lies on its left-hand side.
    pub direction_deg: f64,
    /// Camber: departure of the edge from its chord into the air 2 mm from the corner, µm.
    pub camber_um: f64,
    /// Depth of the flank, µm; the facet behind it is darker.
    pub depth_um: f64,
    /// Angle of the flank's end at the corner to the edge's normal, degrees.
    pub end_deg: f64,
}

/// Wear of the flank.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct FlankWear {
    /// Width of the land in zone B, µm.
    pub vb_um: f64,
    /// Relative scatter of the width along the edge.
    pub scatter: f64,
    /// Relative growth of the width from the middle of the worn length to its far end; as much is
    /// lost towards the corner.
    pub taper: f64,
    /// Length over which it is worn, from the corner, µm.
    pub length_um: f64,
    /// Depth of a notch at the far end beyond VB, µm.
    pub notch_um: f64,
    /// Width beyond VB at the corner, µm.
    pub corner_um: f64,
    /// Depth by which the edge has chipped at most, µm.
    pub chipping_um: f64,
}

/// Surfaces and light; levels are shares of full scale.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct FlankSurface {
    /// Level of the air beside the edge.
    pub air: f64,
    /// Mean level of the flank.
    pub flank: f64,
    /// Contrast of the ground texture.
    pub texture: f64,
    /// Direction of the grinding lines to the edge, degrees.
    pub grinding_deg: f64,
    /// Pitch of the grinding lines, µm.
    pub grinding_um: f64,
    /// Mean level of the land.
    pub land: f64,
    /// Contrast of its streaks.
    pub streaks: f64,
    /// Direction of the streaks to the edge, degrees: 90 where the work slides across the edge
    /// (turning), near 0 where the land wears in layers along it (milling).
    pub streak_deg: f64,
    /// Level of the bright line along the land, where it turns towards the light.
    pub line: f64,
    /// Half width of that line, µm.
    pub line_um: f64,
    /// Its mean place: depth over the width of the land.
    pub line_at: f64,
    /// Level of the rim at the land's border.
    pub rim: f64,
    /// Share of the land under adhering material.
    pub adhesion: f64,
    /// Mean level of the adhering material.
    pub adhesion_level: f64,
    /// Contrast of its grains.
    pub adhesion_grain: f64,
    /// Share of the flank's facets of 5 µm that lie in the direction of the light.
    pub sparkles: f64,
    /// Contrast of the light over the flank: spread of its logarithm.
    pub shade: f64,
    /// Level of a reflex of the light on the flank.
    pub glare: f64,
    /// Place of that reflex along the edge, µm.
    pub glare_at_um: f64,
}

impl Default for FlankScene {
    fn default() -> Self {
        Self {
            columns: 1024,
            rows: 640,
            um_per_px: 2.415,
            blur_px: 0.9,
            noise_counts: 1.5,
            edge: FlankEdge::default(),
            wear: FlankWear::default(),
            surface: FlankSurface::default(),
        }
    }
}

impl Default for FlankEdge {
    fn default() -> Self {
        Self {
            corner_px: [860.0, 170.0],
            direction_deg: 176.0,
            camber_um: 4.0,
            depth_um: 420.0,
            end_deg: -25.0,
        }
    }
}

impl Default for FlankWear {
    fn default() -> Self {
        Self {
            vb_um: 120.0,
            scatter: 0.15,
            taper: 0.0,
            length_um: 1500.0,
            notch_um: 60.0,
            corner_um: 20.0,
            chipping_um: 4.0,
        }
    }
}

impl Default for FlankSurface {
    fn default() -> Self {
        Self {
            air: 0.15,
            flank: 0.4,
            texture: 0.5,
            grinding_deg: 70.0,
            grinding_um: 14.0,
            land: 0.3,
            streaks: 0.3,
            streak_deg: 90.0,
            line: 0.7,
            line_um: 7.0,
            line_at: 0.35,
            rim: 0.4,
            adhesion: 0.1,
            adhesion_level: 0.5,
            adhesion_grain: 0.7,
            sparkles: 0.03,
            shade: 0.7,
            glare: 0.3,
            glare_at_um: 600.0,
        }
    }
}

impl FlankScene {
    /// Checks every value against its range.
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        within("columns", f64::from(self.columns), 64.0, 8192.0)?;
        within("rows", f64::from(self.rows), 64.0, 8192.0)?;
        within("um_per_px", self.um_per_px, 0.05, 100.0)?;
        within("blur_px", self.blur_px, 0.0, 20.0)?;
        within("noise_counts", self.noise_counts, 0.0, 50.0)?;
        within("edge.depth_um", self.edge.depth_um, 1.0, 1e5)?;
        within("edge.camber_um", self.edge.camber_um, -1e3, 1e3)?;
        within("edge.end_deg", self.edge.end_deg, -80.0, 80.0)?;
        within("edge.direction_deg", self.edge.direction_deg, -360.0, 360.0)?;
        let wear = &self.wear;
        within("wear.vb_um", wear.vb_um, 0.0, 5e3)?;
        within("wear.scatter", wear.scatter, 0.0, 1.0)?;
        within("wear.taper", wear.taper, -1.0, 1.0)?;
        within("wear.length_um", wear.length_um, 0.0, 1e5)?;
        within("wear.notch_um", wear.notch_um, 0.0, 5e3)?;
        within("wear.corner_um", wear.corner_um, 0.0, 5e3)?;
        within("wear.chipping_um", wear.chipping_um, 0.0, 500.0)?;
        within("surface.grinding_um", self.surface.grinding_um, 1.0, 1e3)?;
        within("surface.line_um", self.surface.line_um, 0.1, 1e3)?;
        within("surface.streak_deg", self.surface.streak_deg, -180.0, 180.0)?;
        self.surface.check()
    }
}

impl FlankSurface {
    /// Checks levels and contrasts.
    fn check(&self) -> Result<(), RenderError> {
        let s = self;
        let levels = [
            ("surface.air", s.air),
            ("surface.flank", s.flank),
            ("surface.land", s.land),
            ("surface.adhesion", s.adhesion),
            ("surface.adhesion_level", s.adhesion_level),
            ("surface.sparkles", s.sparkles),
            ("surface.line_at", s.line_at),
        ];
        levels.into_iter().try_for_each(|(name, value)| within(name, value, 0.0, 1.0))?;
        let contrasts = [
            ("surface.texture", s.texture),
            ("surface.streaks", s.streaks),
            ("surface.line", s.line),
            ("surface.rim", s.rim),
            ("surface.glare", s.glare),
            ("surface.adhesion_grain", s.adhesion_grain),
            ("surface.shade", s.shade),
        ];
        contrasts.into_iter().try_for_each(|(name, value)| within(name, value, 0.0, 5.0))
    }
}
