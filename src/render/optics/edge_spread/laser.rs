//! Shadow of an edge in collimated laser light without a lens (Fresnel diffraction).
//!
//! ```text
//! I(v) = ½[(½ + C(v))² + (½ + S(v))²],   v = x √(2/(λz))
//! ```
//!
//! z from the edge to the sensor: 25 % at the true edge, 50 % at v = 0.354. In monochromatic light
//! the rings never end (their contrast decreases as √2/πv); a line of finite width, here Gaussian,
//! removes them at about v² = 0.4 λ/Δλ, and a source of finite angle blurs them by z times its
//! angle. Valid for z much larger than the distance from the edge, one edge at a time: the two
//! edges of a wire interfere, see [`LaserShadow::wire`].

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::fresnel_integrals::fresnel;
use super::shifts::Shifts;
use super::table::EdgeSpread;
use crate::render::error::{RenderError, within};

/// Largest error of the table's interpolation, share of full intensity: a third of the family's
/// stated error.
const TOLERANCE: f64 = 3e-6;

/// Full width at half maximum over the standard deviation of a Gaussian line.
const FWHM: f64 = 2.354_820_045;

/// Range of the average over a line, standard deviations.
const LINE_REACH: f64 = 5.0;

/// |v| at the table's start in the shadow over v at its end in the light: there are no rings in the
/// shadow.
const SHADOW_SHARE: f64 = 0.5;

/// A laser gauge's light and distances.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LaserShadow {
    /// Wavelength, nm.
    pub wavelength_nm: f64,
    /// Full width of the line at half maximum, nm; 0 is one colour.
    pub bandwidth_nm: f64,
    /// Distance from the edge to the sensor, mm.
    pub distance_mm: f64,
    /// Half angle of the source as seen from the edge, mrad.
    pub source_half_angle_mrad: f64,
    /// Reach of the table into the light in units of √(λz/2); half of it into the shadow.
    pub reach: f64,
}

impl Default for LaserShadow {
    /// A red laser diode in a shadow gauge.
    fn default() -> Self {
        Self {
            wavelength_nm: 650.0,
            bandwidth_nm: 2.0,
            distance_mm: 40.0,
            source_half_angle_mrad: 0.2,
            reach: 40.0,
        }
    }
}

impl LaserShadow {
    /// Checks every value against its range.
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        within("optics.esf.fresnel.wavelength_nm", self.wavelength_nm, 100.0, 20_000.0)?;
        within("optics.esf.fresnel.bandwidth_nm", self.bandwidth_nm, 0.0, 0.2 * self.wavelength_nm)?;
        within("optics.esf.fresnel.distance_mm", self.distance_mm, 1e-3, 1e5)?;
        within("optics.esf.fresnel.source_half_angle_mrad", self.source_half_angle_mrad, 0.0, 100.0)?;
        within("optics.esf.fresnel.reach", self.reach, 4.0, 120.0)
    }

    /// √(λz/2), µm: the distance for which v = 1.
    pub(crate) fn unit_um(&self) -> f64 {
        (0.5 * self.wavelength_nm * 1e-3 * self.distance_mm * 1e3).sqrt()
    }

    /// The table in µm on the object, which for collimated light is µm on the sensor.
    ///
    /// # Errors
    /// Refuses values outside their ranges.
    pub(crate) fn edge_spread(&self) -> Result<EdgeSpread, RenderError> {
        self.check()?;
        let unit = self.unit_um();
        let line = self.line();
        let (low, high) = (-SHADOW_SHARE * self.reach * unit, self.reach * unit);
        let table = EdgeSpread::tabulate(low, high, TOLERANCE, |d| {
            over_line(&line, |scale| {
                let (value, slope) = monochromatic(d / unit * scale);
                (value, slope * scale / unit)
            })
        })?;
        let radius = self.source_half_angle_mrad * self.distance_mm;
        if radius == 0.0 {
            return Ok(table);
        }
        // The finest ring, at the end of the reach, has the period 2·unit/reach.
        let nodes = 16 + (4.0 * radius * self.reach / unit).ceil() as usize;
        table.spread(&Shifts::disc(radius, nodes), TOLERANCE)
    }

    /// Light behind an opaque wire of `diameter_um` at `x_um` from its axis: the amplitudes of both
    /// edges add.
    ///
    /// Monochromatic or averaged over the line, for a point source.
    ///
    /// # Errors
    /// Refuses values outside their ranges.
    #[cfg(test)]
    pub(crate) fn wire(&self, diameter_um: f64, x_um: f64) -> Result<f64, RenderError> {
        self.check()?;
        within("wire.diameter_um", diameter_um, 0.0, 1e6)?;
        let unit = self.unit_um();
        let half = 0.5 * diameter_um;
        let (light, _) = over_line(&self.line(), |scale| {
            let (right, left) =
                (amplitude((x_um - half) / unit * scale), amplitude((-x_um - half) / unit * scale));
            let (re, im) = (right.0 + left.0, right.1 + left.1);
            (0.5 * (re * re + im * im), 0.0)
        });
        Ok(light)
    }

    /// Nodes over the line as (√(λ0/λ), weight): the trapezoidal rule, three points per period of
    /// the farthest ring.
    fn line(&self) -> Vec<(f64, f64)> {
        let relative = self.bandwidth_nm / FWHM / self.wavelength_nm;
        if relative == 0.0 {
            return vec![(1.0, 1.0)];
        }
        // Beyond ln(1e6) of damping, (πv²σ/2)²/2, the rings are negligible.
        let followed = (0.5 * PI * self.reach * self.reach * relative).min(6.0);
        let half = 12 + (followed * LINE_REACH * 3.0 / PI).ceil() as i32;
        let nodes: Vec<(f64, f64)> = (-half..=half)
            .map(|i| {
                let u = LINE_REACH * f64::from(i) / f64::from(half);
                ((1.0 / (1.0 + relative * u)).sqrt(), (-0.5 * u * u).exp())
            })
            .collect();
        let sum: f64 = nodes.iter().map(|(_, w)| w).sum();
        nodes.into_iter().map(|(s, w)| (s, w / sum)).collect()
    }
}

/// ½ + C(v) and ½ + S(v): the amplitude past a half plane, times √2 and without its common phase.
fn amplitude(v: f64) -> (f64, f64) {
    let (c, s) = fresnel(v);
    (0.5 + c, 0.5 + s)
}

/// I(v) and dI/dv.
pub(super) fn monochromatic(v: f64) -> (f64, f64) {
    let (re, im) = amplitude(v);
    let (sin, cos) = (PI * (0.5 * v * v).rem_euclid(2.0)).sin_cos();
    (0.5 * (re * re + im * im), re * cos + im * sin)
}

fn over_line(line: &[(f64, f64)], f: impl Fn(f64) -> (f64, f64)) -> (f64, f64) {
    line.iter().fold((0.0, 0.0), |(value, slope), (scale, w)| {
        let (v, s) = f(*scale);
        (value + w * v, slope + w * s)
    })
}
