//! The `[contamination]` table. Everything is clean by default.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::render::error::{RenderError, within};

/// Largest density, cm⁻²: above it the field would be opaque.
const DENSEST_PER_CM2: f64 = 1e5;

/// Lognormal sizes: the logarithm of the size is normal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SizeDistribution {
    /// Half of all are smaller, µm.
    pub median_um: f64,
    /// Geometric standard deviation, 1 or more: 1 makes all alike.
    pub geometric_sd: f64,
    /// None is larger, µm.
    pub largest_um: f64,
}

impl SizeDistribution {
    fn new(median_um: f64, geometric_sd: f64, largest_um: f64) -> Self {
        Self { median_um, geometric_sd, largest_um }
    }

    fn check(&self, keys: [&'static str; 3]) -> Result<(), RenderError> {
        within(keys[0], self.median_um, 1e-2, 1e5)?;
        within(keys[1], self.geometric_sd, 1.0, 10.0)?;
        within(keys[2], self.largest_um, self.median_um, 1e6)
    }
}

/// Clouds of coolant mist, drawn anew for every frame: T = exp(-Σ τ exp(-r²/2s²)).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Mist {
    /// Clouds per cm² of the field.
    pub clouds_per_cm2: f64,
    /// Optical depth τ in the middle of a cloud.
    pub optical_depth: f64,
    /// Standard deviation s of a cloud's Gaussian, µm.
    pub size_um: SizeDistribution,
    /// Optical depth everywhere.
    pub haze_depth: f64,
}

impl Default for Mist {
    fn default() -> Self {
        Self {
            clouds_per_cm2: 0.0,
            optical_depth: 0.1,
            size_um: SizeDistribution::new(1500.0, 1.5, 6000.0),
            haze_depth: 0.0,
        }
    }
}

/// Droplets on the protective window: thin plano-convex lenses, fixed in the image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WindowDroplets {
    /// Droplets per cm² of window.
    pub per_cm2: f64,
    /// Radius of the wetted disc, µm.
    pub radius_um: SizeDistribution,
    /// Contact angle, degrees.
    pub contact_angle_deg: f64,
    /// Refractive index (water-based coolant 1.34, oil 1.47).
    pub refractive_index: f64,
}

impl Default for WindowDroplets {
    fn default() -> Self {
        Self {
            per_cm2: 0.0,
            radius_um: SizeDistribution::new(150.0, 1.8, 1500.0),
            contact_angle_deg: 50.0,
            refractive_index: 1.34,
        }
    }
}

/// Droplets in flight: ball lenses, drawn anew for every frame, anywhere in the depth of the beam.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct AirDroplets {
    /// Droplets per cm² of the field, over the whole depth.
    pub per_cm2: f64,
    /// Radius, µm.
    pub radius_um: SizeDistribution,
    /// Refractive index.
    pub refractive_index: f64,
}

impl Default for AirDroplets {
    fn default() -> Self {
        Self { per_cm2: 0.0, radius_um: SizeDistribution::new(60.0, 1.8, 600.0), refractive_index: 1.34 }
    }
}

/// Chips in flight: opaque polygons, drawn anew for every frame, anywhere in the depth of the beam.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Chips {
    /// Chips per cm² of the field, over the whole depth.
    pub per_cm2: f64,
    /// Half length, µm.
    pub half_length_um: SizeDistribution,
    /// Width over length, 0..=1.
    pub aspect: f64,
    /// Corners, 3..=32.
    pub corners: u32,
}

impl Default for Chips {
    fn default() -> Self {
        Self {
            per_cm2: 0.0,
            half_length_um: SizeDistribution::new(800.0, 1.6, 5000.0),
            aspect: 0.35,
            corners: 9,
        }
    }
}

/// Films of coolant and smeared chips that adhere to the shaft and turn with it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Films {
    /// Films per cm² of the shaft's surface.
    pub per_cm2: f64,
    /// Thickness in the middle, µm.
    pub thickness_um: SizeDistribution,
    /// Half extent along and around the shaft, µm.
    pub half_extent_um: SizeDistribution,
}

impl Default for Films {
    fn default() -> Self {
        Self {
            per_cm2: 0.0,
            thickness_um: SizeDistribution::new(8.0, 1.8, 100.0),
            half_extent_um: SizeDistribution::new(1500.0, 1.6, 8000.0),
        }
    }
}

/// Opaque specks on the window, fixed in the image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Dirt {
    /// Specks per cm² of window.
    pub per_cm2: f64,
    /// Radius, µm.
    pub radius_um: SizeDistribution,
    /// Light a speck takes away, 0..=1.
    pub opacity: f64,
}

impl Default for Dirt {
    fn default() -> Self {
        Self { per_cm2: 0.0, radius_um: SizeDistribution::new(60.0, 1.8, 800.0), opacity: 1.0 }
    }
}

/// Straight scratches in the window, fixed in the image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Scratches {
    /// Scratches per cm² of window.
    pub per_cm2: f64,
    /// Width, µm.
    pub width_um: SizeDistribution,
    /// Length, mm.
    pub length_mm: f64,
    /// Light that a scratch scatters out of the beam, 0..=1.
    pub opacity: f64,
}

impl Default for Scratches {
    fn default() -> Self {
        Self { per_cm2: 0.0, width_um: SizeDistribution::new(20.0, 1.5, 200.0), length_mm: 8.0, opacity: 0.8 }
    }
}

/// Everything that soils the view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Contamination {
    /// Distance of the window from the plane of focus, mm.
    pub window_distance_mm: f64,
    /// Depth of the beam, centred on the plane of focus, mm: where things fly.
    pub beam_depth_mm: f64,
    /// Half angle within which deflected light still reaches the sensor (NA of lens and light
    /// together), degrees.
    pub acceptance_half_angle_deg: f64,
    /// Clouds of coolant.
    pub mist: Mist,
    /// Droplets on the window.
    pub window_droplets: WindowDroplets,
    /// Droplets in flight.
    pub air_droplets: AirDroplets,
    /// Chips in flight.
    pub chips: Chips,
    /// Films on the shaft.
    pub films: Films,
    /// Specks on the window.
    pub dirt: Dirt,
    /// Scratches in the window.
    pub scratches: Scratches,
}

impl Default for Contamination {
    /// Clean; the window 60 mm in front of the shaft.
    fn default() -> Self {
        Self {
            window_distance_mm: 60.0,
            beam_depth_mm: 100.0,
            acceptance_half_angle_deg: 1.5,
            mist: Mist::default(),
            window_droplets: WindowDroplets::default(),
            air_droplets: AirDroplets::default(),
            chips: Chips::default(),
            films: Films::default(),
            dirt: Dirt::default(),
            scratches: Scratches::default(),
        }
    }
}

/// `keys!("droplets", "radius_um")` names the three keys of a distribution.
macro_rules! keys {
    ($of:literal) => {
        [
            concat!("contamination.", $of, ".median_um"),
            concat!("contamination.", $of, ".geometric_sd"),
            concat!("contamination.", $of, ".largest_um"),
        ]
    };
}

fn density(key: &'static str, per_cm2: f64) -> Result<(), RenderError> {
    within(key, per_cm2, 0.0, DENSEST_PER_CM2)
}

impl Contamination {
    /// Whether neither window nor air nor shaft is contaminated.
    pub(crate) fn is_clean(&self) -> bool {
        self.is_clear() && self.films.per_cm2 == 0.0
    }

    /// Whether no pixel loses light; films on the shaft may still raise its edges.
    pub(crate) fn is_clear(&self) -> bool {
        let densities = [
            self.mist.clouds_per_cm2,
            self.mist.haze_depth,
            self.window_droplets.per_cm2,
            self.air_droplets.per_cm2,
            self.chips.per_cm2,
            self.dirt.per_cm2,
            self.scratches.per_cm2,
        ];
        densities.iter().all(|d| *d == 0.0)
    }

    /// Checks every value against its range.
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        within("contamination.window_distance_mm", self.window_distance_mm, 0.0, 1e4)?;
        within("contamination.beam_depth_mm", self.beam_depth_mm, 0.0, 1e4)?;
        within("contamination.acceptance_half_angle_deg", self.acceptance_half_angle_deg, 0.0, 45.0)?;
        self.check_air()?;
        self.check_window()?;
        density("contamination.films.per_cm2", self.films.per_cm2)?;
        self.films.thickness_um.check(keys!("films.thickness_um"))?;
        self.films.half_extent_um.check(keys!("films.half_extent_um"))
    }

    fn check_air(&self) -> Result<(), RenderError> {
        density("contamination.mist.clouds_per_cm2", self.mist.clouds_per_cm2)?;
        within("contamination.mist.optical_depth", self.mist.optical_depth, 0.0, 20.0)?;
        within("contamination.mist.haze_depth", self.mist.haze_depth, 0.0, 20.0)?;
        self.mist.size_um.check(keys!("mist.size_um"))?;
        density("contamination.air_droplets.per_cm2", self.air_droplets.per_cm2)?;
        self.air_droplets.radius_um.check(keys!("air_droplets.radius_um"))?;
        within("contamination.air_droplets.refractive_index", self.air_droplets.refractive_index, 1.01, 3.0)?;
        density("contamination.chips.per_cm2", self.chips.per_cm2)?;
        self.chips.half_length_um.check(keys!("chips.half_length_um"))?;
        within("contamination.chips.aspect", self.chips.aspect, 0.01, 1.0)?;
        within("contamination.chips.corners", f64::from(self.chips.corners), 3.0, 32.0)
    }

    fn check_window(&self) -> Result<(), RenderError> {
        let droplets = &self.window_droplets;
        density("contamination.window_droplets.per_cm2", droplets.per_cm2)?;
        droplets.radius_um.check(keys!("window_droplets.radius_um"))?;
        within("contamination.window_droplets.contact_angle_deg", droplets.contact_angle_deg, 1.0, 90.0)?;
        within("contamination.window_droplets.refractive_index", droplets.refractive_index, 1.01, 3.0)?;
        density("contamination.dirt.per_cm2", self.dirt.per_cm2)?;
        self.dirt.radius_um.check(keys!("dirt.radius_um"))?;
        within("contamination.dirt.opacity", self.dirt.opacity, 0.0, 1.0)?;
        density("contamination.scratches.per_cm2", self.scratches.per_cm2)?;
        self.scratches.width_um.check(keys!("scratches.width_um"))?;
        within("contamination.scratches.length_mm", self.scratches.length_mm, 1e-3, 1e3)?;
        within("contamination.scratches.opacity", self.scratches.opacity, 0.0, 1.0)
    }
}
