//! Settings of the ring measurement.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::setting::{SettingError, within};

/// Settings of `measure --shape ring`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RingSettings {
    /// Whether the part is brighter than its surroundings.
    pub bright_on_dark: bool,
    /// Least outer diameter of a part, px. At least 16.
    pub min_diameter_px: f64,
    /// Radial calipers around the circle; halved until each holds at least 2 px of arc. 64
    /// ..= 4096.
    pub calipers: usize,
    /// Half width of the band along an edge, px. 3 ..= 20.
    pub half_band_px: f64,
    /// Departure of a caliper from its neighbours beyond which it is dirt, in robust standard
    /// deviations. At least 4.
    pub outlier_sigmas: f64,
    /// Least share of calipers that must be good. 0.5 ..= 1.
    pub min_fill: f64,
    /// Gaussian filter of the roundness, undulations per revolution. Above 0.
    pub roundness_cutoff_upr: f64,
    /// Radius of a stylus tip, px: the diameter is also given as a ball of that radius would feel
    /// it, burrs included, to be compared with a tactile machine. Above 0, at most 1000; without it
    /// the largest that ISO 12181-2 allows at the roundness' cutoff (diameter/15 at 50 upr).
    pub stylus_radius_px: Option<f64>,
    /// Scale and edge offset; pixels only without it.
    pub scale: Option<RingScale>,
}

impl Default for RingSettings {
    fn default() -> Self {
        Self {
            bright_on_dark: false,
            min_diameter_px: 20.0,
            calipers: 1440,
            half_band_px: 6.0,
            outlier_sigmas: 8.0,
            min_fill: 0.7,
            roundness_cutoff_upr: 50.0,
            stylus_radius_px: None,
            scale: None,
        }
    }
}

/// From pixels to millimetres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RingScale {
    /// Scale, µm per px. Above 0.
    pub um_per_px: f64,
    /// Its standard uncertainty, µm per px.
    pub u_um_per_px: f64,
    /// Distance of the true edge from the 50 % point, px, positive where the part reaches into the
    /// light: it adds twice to an outer diameter and is taken twice from an inner one.
    pub edge_offset_px: f64,
    /// Its standard uncertainty, px.
    pub u_edge_offset_px: f64,
}

impl RingSettings {
    /// Checks every value.
    ///
    /// # Errors
    /// Names the first key out of range.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        within("ring.min_diameter_px", self.min_diameter_px, 16.0, 1e5, "16 or more")?;
        within("ring.calipers", self.calipers as f64, 64.0, 4096.0, "64 to 4096")?;
        within("ring.half_band_px", self.half_band_px, 3.0, 20.0, "3 to 20")?;
        within("ring.outlier_sigmas", self.outlier_sigmas, 4.0, 1e6, "4 or more")?;
        within("ring.min_fill", self.min_fill, 0.5, 1.0, "0.5 to 1")?;
        within(
            "ring.roundness_cutoff_upr",
            self.roundness_cutoff_upr,
            1e-3,
            1e5,
            "above 0; ISO 12181-2: 15, 50, 150",
        )?;
        within(
            "ring.stylus_radius_px",
            self.stylus_radius_px.unwrap_or(1.0),
            1e-3,
            1e3,
            "above 0, at most 1000",
        )?;
        let Some(scale) = self.scale else { return Ok(()) };
        within("ring.scale.um_per_px", scale.um_per_px, 1e-6, 1e6, "above 0")?;
        within("ring.scale.u_um_per_px", scale.u_um_per_px, 0.0, 1e6, "0 or more")?;
        within("ring.scale.edge_offset_px", scale.edge_offset_px, -20.0, 20.0, "-20 to 20")?;
        within("ring.scale.u_edge_offset_px", scale.u_edge_offset_px, 0.0, 20.0, "0 or more")
    }
}
