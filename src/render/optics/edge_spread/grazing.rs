//! Grazing reflection: a polished cylinder in diffuse light reflects light beside its edge into the
//! lens.
//!
//! In the plane across the axis, a ray that reaches the camera at the angle α and appears to come
//! from the height x in the plane of the axis meets a cylinder of radius R at the glancing angle γ
//! with cos γ = (x/R) cos α. Traced back it leaves towards the source at α - 2γ, and is lit if that
//! lies within the source's half angle θ:
//!
//! ```text
//! L(x, α) = 1 where x cos α > R, else ρ(γ) where 2γ - α ≤ θ, else 0
//! ```
//!
//! For rays along the optical axis the strip is Rθ²/8 wide (Dθ²/8 of diameter: 20 mm: 19 µm at
//! 5°, 0.76 µm at 1°); off the axis it grows to Rθ²/6 at α = θ/3. Skew rays, with the angle ζ along
//! the axis, preserve ζ: source and pupil shrink to √(θ²-ζ²) and √(NA²-ζ²). The light of all pupil
//! points adds up; interference between direct and reflected light is neglected (correct for a
//! source wider than the pupil), and so is the defocus of reflected rays beyond their own angle.

use std::f64::consts::FRAC_PI_2;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::quadrature::{gauss_legendre, panels};
use super::shifts::Shifts;
use super::table::EdgeSpread;
use crate::render::error::{RenderError, within};

/// Cells over the strip, each of uniform brightness.
const CELLS: usize = 256;

/// Points over which a cell's brightness is averaged: the strip's end is resolved to Rθ²/12000.
const POINTS: usize = 8;

/// Chords of the pupil, and nodes along a chord between two breaks.
const CHORDS: usize = 16;
const ALONG: usize = 6;

/// Largest error of the table's interpolation, share of full intensity.
const TOLERANCE: f64 = 1e-6;

/// The cylinder's surface and the light around it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GrazingReflection {
    /// Half angle of the diffuse light, degrees.
    pub source_half_angle_deg: f64,
    /// Half angle the lens accepts (asin NA), degrees; 0 takes rays along the optical axis only.
    pub acceptance_half_angle_deg: f64,
    /// Share of the surface that mirrors: 1 polished, 0 matt.
    pub polished_share: f64,
    /// Refractive index n of the surface (steel 2.9 at 590 nm).
    pub refractive_index: f64,
    /// Extinction coefficient k of the surface (steel 3.1 at 590 nm).
    pub extinction: f64,
}

impl Default for GrazingReflection {
    /// Ground steel in front of a telecentric backlight.
    fn default() -> Self {
        Self {
            source_half_angle_deg: 1.0,
            acceptance_half_angle_deg: 0.0,
            polished_share: 0.5,
            refractive_index: 2.9,
            extinction: 3.1,
        }
    }
}

impl GrazingReflection {
    /// Checks every value against its range.
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        within("optics.reflection.source_half_angle_deg", self.source_half_angle_deg, 0.0, 30.0)?;
        within("optics.reflection.acceptance_half_angle_deg", self.acceptance_half_angle_deg, 0.0, 30.0)?;
        within("optics.reflection.polished_share", self.polished_share, 0.0, 1.0)?;
        within("optics.reflection.refractive_index", self.refractive_index, 0.05, 20.0)?;
        within("optics.reflection.extinction", self.extinction, 0.0, 20.0)
    }

    /// Width of the lit strip at one edge for rays at `acceptance_deg` to the optical axis, µm
    /// (paraxial).
    ///
    /// R(θ-α)(θ+3α)/8: Rθ²/8 on the axis; its maximum Rθ²/6 at α = θ/3.
    #[cfg(test)]
    pub(crate) fn strip_um(&self, radius_mm: f64, acceptance_deg: f64) -> f64 {
        let (theta, alpha) = (self.source_half_angle_deg.to_radians(), acceptance_deg.to_radians());
        radius_mm * 1e3 * (theta - alpha) * (theta + 3.0 * alpha) / 8.0
    }

    /// Reflectance of the polished share for unpolarised light at the glancing angle γ (Fresnel,
    /// n + ik).
    ///
    /// With c = sin γ the cosine of incidence, for metals |n + ik|² ≫ 1 (Born & Wolf 14.2):
    /// R⊥ = |(c - m)/(c + m)|², R∥ = |(m²c - q)/(m²c + q)|², q = √(m² - 1 + c²), m = n + ik.
    pub(crate) fn reflectance(&self, glancing_rad: f64) -> f64 {
        let c = glancing_rad.sin().clamp(0.0, 1.0);
        let (n, k) = (self.refractive_index, self.extinction);
        let square = (n * n - k * k, 2.0 * n * k);
        // q = √(m² - 1 + c²), the root with a positive real part.
        let (re, im) = (square.0 - 1.0 + c * c, square.1);
        let modulus = re.hypot(im);
        let q = ((0.5 * (modulus + re)).max(0.0).sqrt(), (0.5 * (modulus - re)).max(0.0).sqrt());
        let ratio = |a: (f64, f64), b: (f64, f64)| {
            ((a.0 - b.0).powi(2) + (a.1 - b.1).powi(2))
                / ((a.0 + b.0).powi(2) + (a.1 + b.1).powi(2)).max(1e-300)
        };
        let perpendicular = ratio((c, 0.0), q);
        let parallel = ratio((square.0 * c, square.1 * c), q);
        self.polished_share * 0.5 * (perpendicular + parallel)
    }

    /// Light at `x_mm` from the cylinder's axis in the plane of focus, before diffraction: 1 beside
    /// the cylinder.
    ///
    /// Paraxial in the angle along the axis.
    ///
    /// # Errors
    /// Refuses values outside their ranges.
    #[cfg(test)]
    pub(crate) fn light(&self, radius_mm: f64, x_mm: f64) -> Result<f64, RenderError> {
        self.check()?;
        within("shaft.radius_mm", radius_mm, 1e-4, 1e4)?;
        Ok(self.mean_light(x_mm / radius_mm, &self.chords(), &gauss_legendre(ALONG)))
    }

    /// Chords of the pupil as (half length of the chord in α, half angle of the source in its
    /// plane, weight).
    fn chords(&self) -> Vec<(f64, f64, f64)> {
        let theta = self.source_half_angle_deg.to_radians();
        // Direct light reaches the pupil only within the cone of the source.
        let lit = self.acceptance_half_angle_deg.to_radians().min(theta);
        if lit == 0.0 {
            return vec![(0.0, theta, 1.0)];
        }
        let chord = |(u, w): &(f64, f64)| {
            let (sin, cos) = (FRAC_PI_2 * u).sin_cos();
            let source = (theta * theta - (lit * sin).powi(2)).max(0.0).sqrt();
            // ζ = lit sin(πu/2): dζ and the chord's length are both proportional to the cosine,
            // over the area π lit².
            (lit * cos, source, w * cos * cos)
        };
        gauss_legendre(CHORDS).iter().map(chord).collect()
    }

    fn mean_light(&self, height: f64, chords: &[(f64, f64, f64)], rule: &[(f64, f64)]) -> f64 {
        chords.iter().map(|(half, source, w)| w * self.chord_light(height, *half, *source, rule)).sum()
    }

    /// Mean over α in ±`half`, divided where rays begin to meet the cylinder (cos α = R/x) and
    /// where they leave the source (3α² - 2θα + 8h - θ² = 0 for a depth of Rh in the shadow).
    fn chord_light(&self, height: f64, half: f64, source: f64, rule: &[(f64, f64)]) -> f64 {
        if half == 0.0 {
            return self.radiance(height, 0.0, source);
        }
        let depth = 1.0 - height;
        let meets = (1.0 / height.max(1.0)).acos();
        let root = (4.0 * source * source - 24.0 * depth).max(0.0).sqrt();
        let breaks = [-meets, meets, (source - root) / 3.0, (source + root) / 3.0];
        let nodes = panels(-half, half, &breaks, 2.0 * half, rule);
        nodes.iter().map(|(alpha, w)| w * self.radiance(height, *alpha, source)).sum::<f64>() / (2.0 * half)
    }

    fn radiance(&self, height: f64, alpha: f64, source: f64) -> f64 {
        let cos_glancing = height * alpha.cos();
        if cos_glancing > 1.0 {
            return 1.0;
        }
        let glancing = cos_glancing.acos();
        if 2.0 * glancing - alpha <= source { self.reflectance(glancing) } else { 0.0 }
    }

    /// The edge's light as shifted edges: the share of light that begins at each distance (µm into
    /// the light).
    ///
    /// # Errors
    /// Refuses values outside their ranges.
    pub(crate) fn shifts(&self, radius_mm: f64) -> Result<Shifts, RenderError> {
        self.check()?;
        within("shaft.radius_mm", radius_mm, 1e-4, 1e4)?;
        let (chords, rule) = (self.chords(), gauss_legendre(ALONG));
        let theta = self.source_half_angle_deg.to_radians();
        let lit = self.acceptance_half_angle_deg.to_radians().min(theta);
        // Strip: to Rθ²/6 in the shadow; direct light of rays at α begins at R/cos α.
        let low = -radius_mm * (theta * theta / 6.0) * 1.05;
        let high = radius_mm * (1.0 / lit.cos() - 1.0);
        let step = (high - low) / CELLS as f64;
        if step <= 0.0 {
            return Ok(Shifts::none());
        }
        let light = |i: usize| {
            let point = |j: usize| low + (i as f64 - 1.0 + (j as f64 + 0.5) / POINTS as f64) * step;
            let light = |j| self.mean_light(1.0 + point(j) / radius_mm, &chords, &rule);
            (0..POINTS).map(light).sum::<f64>() / POINTS as f64
        };
        let mut before = 0.0;
        let mut nodes = Vec::with_capacity(CELLS + 2);
        for i in 0..=CELLS {
            let now = light(i);
            nodes.push(((low + (i as f64 - 1.0) * step) * 1e3, now - before));
            before = now;
        }
        nodes.push((high * 1e3, 1.0 - before));
        nodes.retain(|n| n.1 != 0.0);
        Ok(Shifts::new(nodes))
    }

    /// The edge of a cylinder of `radius_mm` seen through optics with the knife-edge response
    /// `edge`.
    ///
    /// # Errors
    /// Refuses values outside their ranges.
    pub(crate) fn edge_spread(&self, edge: &EdgeSpread, radius_mm: f64) -> Result<EdgeSpread, RenderError> {
        edge.spread(&self.shifts(radius_mm)?, TOLERANCE)
    }
}
