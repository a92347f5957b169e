//! A shaft prepared for silhouettes: bounds, mean radii, and the ranges where its outline is not
//! smooth.

use std::f64::consts::TAU;

use glam::{DMat2, DVec2};

use super::check::{bounds, check};
use super::features;
use crate::numerics::neighbours::{linear_between, neighbours};
use crate::render::error::RenderError;
use crate::shaft::{ProfileKnot, Shaft};

/// Fewest segments of a revolution: limits the half width of a segment to 0.0123 rad, where cos and
/// sin to the sixth order are exact to 1e-17.
const FEWEST_SEGMENTS: usize = 256;

/// Segments per undulation: k·(half width) ≤ 0.25, where the fifth-order Taylor polynomial of a
/// lobe errs by 3.4e-7 a_k.
const SEGMENTS_PER_LOBE: usize = 13;

/// Change of the profile's slope up to which a corner counts as straight within the blur: it
/// displaces the mean over whole columns by 8e-6 px.
const CORNER: f64 = 3e-4;

/// A shaft prepared for silhouettes: bounds and the division of the circle.
#[derive(Clone, Debug)]
pub(crate) struct Outline {
    pub(super) shaft: Shaft,
    /// Segments of a revolution, a multiple of the texture's nodes.
    pub(super) segments: usize,
    /// Segments between two nodes of the texture.
    pub(super) per_node: usize,
    /// Bounds of lobes + texture, mm.
    pub(super) low_mm: f64,
    pub(super) high_mm: f64,
    /// Radius of a disc inside every slice, with flats and keyways cut, mm.
    pub(super) core_mm: f64,
    /// z of every shoulder, ascending.
    pub(super) shoulders_mm: Vec<f64>,
    /// Ranges of z with corners, threads or ends of features, ascending by their start.
    pub(super) broken_mm: Vec<(f64, f64)>,
    pub(super) tilt: DMat2,
    pub(super) sin_tilt: f64,
    pub(super) cos_tilt: f64,
}

impl Outline {
    /// Prepares a shaft.
    ///
    /// # Errors
    /// Refuses a shaft that cannot be drawn: no knots, knots out of order, values that are not
    /// finite, a radius that is not positive, lobes below order 2, a texture grid that does not fit
    /// its heights.
    pub(crate) fn new(shaft: Shaft) -> Result<Self, RenderError> {
        check(&shaft)?;
        let highest = shaft.lobes.iter().map(|l| l.order_upr as usize).max().unwrap_or(0);
        let wanted = FEWEST_SEGMENTS.max(SEGMENTS_PER_LOBE * highest);
        let nodes = shaft.texture.as_ref().map_or(1, |t| t.nodes_theta);
        let per_node = wanted.div_ceil(nodes);
        let lobes: f64 = shaft.lobes.iter().map(|l| l.amplitude_mm.abs()).sum();
        let (low, high) = shaft.texture.as_ref().map_or((0.0, 0.0), bounds);
        let (below, above) = features::bounds(&shaft.features);
        let (sin_tilt, cos_tilt) = (shaft.pose.tilt_mrad * 1e-3).sin_cos();
        Ok(Self {
            segments: nodes * per_node,
            per_node,
            low_mm: low - lobes + below,
            high_mm: high + lobes + above,
            core_mm: features::core_mm(&shaft, low - lobes + below),
            shoulders_mm: shoulders(&shaft.profile),
            broken_mm: features::broken(&shaft, CORNER),
            tilt: DMat2::from_cols(DVec2::new(cos_tilt, sin_tilt), DVec2::new(-sin_tilt, cos_tilt)),
            sin_tilt,
            cos_tilt,
            shaft,
        })
    }

    /// The shaft.
    pub(crate) fn shaft(&self) -> &Shaft {
        &self.shaft
    }

    /// Lower bound of half the height of any slice, mm.
    pub(crate) fn smallest_radius_mm(&self) -> f64 {
        self.core_mm
    }

    /// Bound of the distance of any slice's axis from the plane of focus, mm; 0 for a straight,
    /// centred shaft.
    pub(crate) fn largest_depth_mm(&self) -> f64 {
        let bow = self.shaft.bow.iter().map(|k| k.x_mm.hypot(k.y_mm)).fold(0.0, f64::max);
        let deflection = self.shaft.deflection.iter().map(|k| k.y_mm.abs()).fold(0.0, f64::max);
        let spindle = &self.shaft.spindle;
        let synchronous: f64 = spindle.synchronous.iter().map(|h| h.y_um.abs()).sum();
        let spindle_mm = (synchronous + 4.0 * spindle.asynchronous_rms_um) * 1e-3;
        bow + deflection + self.shaft.eccentricity.amplitude_mm.abs() + spindle_mm
    }

    /// Smallest and largest mean radius R(z), mm.
    pub(crate) fn mean_radii_mm(&self) -> (f64, f64) {
        let waves: f64 = self.shaft.features.waves.iter().map(|w| w.amplitude_mm.abs()).sum();
        let radii = self.shaft.profile.iter().map(|k| k.radius_mm);
        (radii.clone().fold(f64::INFINITY, f64::min) - waves, radii.fold(0.0, f64::max) + waves)
    }

    /// Mean radius at z, mm: profile and waves.
    pub(crate) fn mean_radius_mm(&self, z_mm: f64) -> f64 {
        let wave = |w: &crate::shaft::AxialWave| {
            w.amplitude_mm * (TAU * z_mm / w.wavelength_mm + w.phase_deg.to_radians()).cos()
        };
        mean_radius(&self.shaft.profile, z_mm) + self.shaft.features.waves.iter().map(wave).sum::<f64>()
    }

    /// Whether a corner, a thread or the end of a feature lies in `from_mm..=to_mm`, so that the
    /// outline may not be smooth there.
    pub(crate) fn is_broken(&self, from_mm: f64, to_mm: f64) -> bool {
        let after = self.broken_mm.partition_point(|(start, _)| *start <= to_mm);
        after.checked_sub(1).is_some_and(|last| self.broken_mm[last].1 >= from_mm)
    }

    /// Undulations per revolution of the finest form that turns with the shaft.
    pub(crate) fn undulations(&self) -> f64 {
        let f = &self.shaft.features;
        let lobes = self.shaft.lobes.iter().map(|l| l.order_upr).max().unwrap_or(1);
        let cut = if f.flats.is_empty() && f.keyways.is_empty() { 1 } else { 12 };
        let spindle = self.shaft.spindle.synchronous.iter().map(|h| h.order).max().unwrap_or(1);
        f64::from(lobes.max(cut).max(spindle))
    }

    /// Whether the outline consists of level pieces and upright shoulders alone, apart from form
    /// errors.
    pub(crate) fn is_stepped(&self) -> bool {
        let (shaft, features) = (&self.shaft, &self.shaft.features);
        let level = |k: &[ProfileKnot]| k[0].radius_mm == k[1].radius_mm || k[0].z_mm == k[1].z_mm;
        let uncut = features.helices.is_empty() && features.flats.is_empty() && features.keyways.is_empty();
        uncut && self.sin_tilt == 0.0 && shaft.profile.windows(2).all(level)
    }

    /// Whether the outline has any corner, thread or end of a feature.
    pub(crate) fn has_breaks(&self) -> bool {
        !self.broken_mm.is_empty()
    }

    /// z at which the outline changes direction or height between `from_mm` and `to_mm`, ascending.
    pub(crate) fn breaks_mm(&self, from_mm: f64, to_mm: f64) -> Vec<f64> {
        let first = self.shaft.profile.partition_point(|k| k.z_mm <= from_mm);
        let mut breaks: Vec<f64> =
            self.shaft.profile[first..].iter().map(|k| k.z_mm).take_while(|z| *z < to_mm).collect();
        let features = &self.shaft.features;
        let ends = features
            .helices
            .iter()
            .map(|h| [h.from_mm, h.to_mm])
            .chain(features.flats.iter().map(|f| [f.from_mm, f.to_mm]))
            .chain(features.keyways.iter().map(|k| [k.from_mm, k.to_mm]));
        breaks.extend(ends.flatten().filter(|z| *z > from_mm && *z < to_mm));
        breaks.sort_by(f64::total_cmp);
        breaks.dedup();
        breaks
    }
}

/// z of every shoulder: two knots at the same z.
fn shoulders(profile: &[ProfileKnot]) -> Vec<f64> {
    profile.windows(2).filter(|k| k[0].z_mm == k[1].z_mm).map(|k| k[0].z_mm).collect()
}

pub(super) fn mean_radius(profile: &[ProfileKnot], z_mm: f64) -> f64 {
    let pair = neighbours(profile, |k| k.z_mm <= z_mm);
    linear_between(pair, z_mm, |k| (k.z_mm, k.radius_mm)).unwrap_or(f64::NAN)
}
