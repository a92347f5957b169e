//! Partially coherent edge: the image of an opaque half plane through a telecentric lens with a
//! circular pupil, lit by a circular source of S = NA_illumination/NA_lens, of one wavelength or a
//! LED's band.
//!
//! S = 0 is coherent (collimated light), S = ∞ incoherent. Scalar and paraxial (NA below 0.2), no
//! aberration except defocus. In focus the light at the true edge is 0.250 (S = 0), 0.2573 (0.5),
//! 1/3 (1), 0.4334 (1.5) of the full light, and the 50 % point lies 0.106, 0.108, 0.0935, 0.039
//! λ/NA in the light. See `transmission` for the method.

use std::collections::VecDeque;
use std::f64::consts::{PI, TAU};
use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::quadrature::{gauss_legendre, panels};
use super::shifts::Shifts;
use super::table::EdgeSpread;
use super::transmission::{Spectrum, incoherent};
use crate::render::error::{RenderError, within};

/// Largest error of the table's interpolation, share of full intensity.
const TOLERANCE: f64 = 1e-6;

/// Nodes per panel of the frequency integral, and the largest phase over a panel.
const NODES: usize = 16;
const PANEL_PHASE: f64 = 6.0;

/// Width of a Gaussian at half its height in its standard deviation, 2√(2 ln 2).
const FWHM: f64 = 2.354_820_045;

/// Rule of Gauss and Hermite for a normal distribution: places in σ and weights. A LED's band is
/// taken as Gaussian; its image depends on λ so smoothly that five are exact to 1e-5 of full light
/// at a tenth of the wavelength.
const BAND: [(f64, f64); 5] = [
    (-2.856_970_013_872_806, 0.011_257_411_327_720_7),
    (-1.355_626_179_974_266, 0.222_075_922_005_612_6),
    (0.0, 0.533_333_333_333_333_3),
    (1.355_626_179_974_266, 0.222_075_922_005_612_6),
    (2.856_970_013_872_806, 0.011_257_411_327_720_7),
];

/// Coherent light below this S, incoherent above [`INCOHERENT`]: the table differs by less than
/// 1e-5 there.
const COHERENT: f64 = 1e-3;
const INCOHERENT: f64 = 1e3;

/// The lens, its light and the plane of the edge.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PartiallyCoherentEdge {
    /// Numerical aperture of the lens on the side of the object.
    #[serde(rename = "numerical_aperture")]
    pub na: f64,
    /// S = NA of the light over NA of the lens: 0 coherent, above 1000 incoherent.
    pub coherence_ratio: f64,
    /// Wavelength, nm; the middle of the band of a LED.
    pub wavelength_nm: f64,
    /// Width of a LED's band at half its height, nm; 0 for one wavelength.
    #[serde(skip_serializing_if = "is_zero")]
    pub bandwidth_nm: f64,
    /// Distance of the edge from the plane of focus, mm; the sign does not matter.
    pub defocus_mm: f64,
    /// Reach of the table to either side of the edge, in λ/NA; beyond it the light is level.
    pub reach: f64,
    /// Standard deviation of further blur (aberration, sensor), µm on the object.
    pub extra_sigma_um: f64,
}

impl Default for PartiallyCoherentEdge {
    /// NA 0.02, half-filled pupil, green light.
    fn default() -> Self {
        Self {
            na: 0.02,
            coherence_ratio: 0.5,
            wavelength_nm: 525.0,
            bandwidth_nm: 0.0,
            defocus_mm: 0.0,
            reach: 20.0,
            extra_sigma_um: 0.0,
        }
    }
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl PartiallyCoherentEdge {
    /// Checks every value against its range.
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        within("optics.esf.partially_coherent.numerical_aperture", self.na, 1e-4, 0.5)?;
        within("optics.esf.partially_coherent.coherence_ratio", self.coherence_ratio, 0.0, 1e6)?;
        within("optics.esf.partially_coherent.wavelength_nm", self.wavelength_nm, 100.0, 20_000.0)?;
        within(
            "optics.esf.partially_coherent.bandwidth_nm",
            self.bandwidth_nm,
            0.0,
            0.4 * self.wavelength_nm,
        )?;
        within("optics.esf.partially_coherent.reach", self.reach, 2.0, 200.0)?;
        within("optics.esf.partially_coherent.extra_sigma_um", self.extra_sigma_um, 0.0, 1e4)?;
        // Geometric blur of 2·z·λ/NA has to stay within the reach.
        let largest_mm = 0.25 * self.reach * self.unit_um() / self.na * 1e-3;
        within("optics.esf.partially_coherent.defocus_mm", self.defocus_mm, -largest_mm, largest_mm)
    }

    /// λ/NA, µm.
    pub(crate) fn unit_um(&self) -> f64 {
        self.wavelength_nm * 1e-3 / self.na
    }

    /// Defocus in λ/NA².
    pub(crate) fn defocus(&self) -> f64 {
        self.defocus_mm.abs() * 1e3 * self.na / self.unit_um()
    }

    /// The table in µm on the object.
    ///
    /// # Errors
    /// Refuses values outside their ranges.
    pub(crate) fn edge_spread(&self) -> Result<EdgeSpread, RenderError> {
        self.check()?;
        if let Some((_, table)) = tables().iter().find(|(edge, _)| edge == self) {
            return Ok(table.clone());
        }
        let table = self.computed()?;
        let mut kept = tables();
        if kept.len() == MOST_KEPT {
            kept.pop_front();
        }
        kept.push_back((self.clone(), table.clone()));
        Ok(table)
    }

    fn computed(&self) -> Result<EdgeSpread, RenderError> {
        let unit = self.unit_um();
        let band = self.band();
        let reach = self.reach * unit;
        let table = EdgeSpread::tabulate(-reach, reach, TOLERANCE, |d| {
            band.iter().fold((0.0, 0.0), |(sum, steepness), (unit, share, waves)| {
                let (value, slope) = waves.at(d / unit);
                (sum + share * value, steepness + share * slope / unit)
            })
        })?;
        self.blurred(table, TOLERANCE)
    }
}

impl PartiallyCoherentEdge {
    /// λ/NA (µm), share of the light and image of each wavelength of the band.
    fn band(&self) -> Vec<(f64, f64, Waves)> {
        let one = |wavelength_nm: f64, share: f64| {
            let at = Self { wavelength_nm, ..self.clone() };
            let reach = self.reach * self.wavelength_nm / wavelength_nm;
            (at.unit_um(), share, Waves::new(self.coherence_ratio, at.defocus(), reach))
        };
        self.wavelengths().into_iter().map(|(nm, share)| one(nm, share)).collect()
    }

    /// Wavelengths (nm) of the band, and their shares of the light.
    pub(super) fn wavelengths(&self) -> Vec<(f64, f64)> {
        if self.bandwidth_nm == 0.0 {
            return vec![(self.wavelength_nm, 1.0)];
        }
        let sigma_nm = self.bandwidth_nm / FWHM;
        BAND.iter().map(|(x, share)| (self.wavelength_nm + x * sigma_nm, *share)).collect()
    }

    /// A table under the further blur.
    ///
    /// # Errors
    /// As [`EdgeSpread::tabulate`].
    pub(super) fn blurred(&self, table: EdgeSpread, tolerance: f64) -> Result<EdgeSpread, RenderError> {
        if self.extra_sigma_um == 0.0 {
            return Ok(table);
        }
        // The trapezoidal rule samples the table's finest ring, λ/2NA, at twelve points.
        let nodes = 41 + (12.5 * 24.0 * self.extra_sigma_um / self.unit_um()).ceil() as usize;
        table.spread(&Shifts::gaussian(self.extra_sigma_um, nodes), tolerance)
    }
}

/// Cache of the tables computed last: each takes half a second, and every optical setup with the
/// same lens needs it again.
static TABLES: Mutex<VecDeque<(PartiallyCoherentEdge, EdgeSpread)>> = Mutex::new(VecDeque::new());
const MOST_KEPT: usize = 32;

fn tables() -> MutexGuard<'static, VecDeque<(PartiallyCoherentEdge, EdgeSpread)>> {
    TABLES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The edge's image as a sum over spatial frequencies, distances in λ/NA.
enum Waves {
    /// (ν, weight·Gr/πν, weight·Gi/πν).
    Spectrum(Vec<(f64, f64, f64)>),
    /// Coherent light: amplitude = 1/2 + Σ w e^{-iπzf²} sin(2πfx)/πf, as (f, re, im).
    Amplitude(Vec<(f64, f64, f64)>),
}

impl Waves {
    fn new(ratio: f64, defocus: f64, reach: f64) -> Self {
        let rule = gauss_legendre(NODES);
        let panel = PANEL_PHASE / (TAU * reach);
        if ratio < COHERENT {
            let nodes = panels(0.0, 1.0, &[], panel.min(0.25 / (1.0 + defocus)), &rule);
            let term = |(f, w): (f64, f64)| {
                let (sin, cos) = (-PI * defocus * f * f).sin_cos();
                (f, w * cos / (PI * f), w * sin / (PI * f))
            };
            return Self::Amplitude(nodes.into_iter().map(term).collect());
        }
        let spectrum = Spectrum::new(ratio, defocus);
        let nodes = panels(0.0, 2.0, &spectrum.breaks(), panel.min(0.1 / (1.0 + defocus)), &rule);
        let term = |(nu, w): &(f64, f64)| {
            let (re, im) =
                if ratio > INCOHERENT { (incoherent(*nu, defocus), 0.0) } else { spectrum.at(*nu) };
            (*nu, w * re / (PI * nu), w * im / (PI * nu))
        };
        Self::Spectrum(nodes.par_iter().map(term).collect())
    }

    /// I(x) and dI/dx.
    fn at(&self, x: f64) -> (f64, f64) {
        match self {
            Self::Spectrum(terms) => terms.iter().fold((0.5, 0.0), |(value, slope), (nu, re, im)| {
                let (sin, cos) = (TAU * nu * x).sin_cos();
                (value + re * sin + im * cos, slope + TAU * nu * (re * cos - im * sin))
            }),
            Self::Amplitude(terms) => {
                let mut sum = [0.5, 0.0, 0.0, 0.0];
                for (f, re, im) in terms {
                    let (sin, cos) = (TAU * f * x).sin_cos();
                    let along = TAU * f * cos;
                    sum = [sum[0] + re * sin, sum[1] + im * sin, sum[2] + re * along, sum[3] + im * along];
                }
                (sum[0] * sum[0] + sum[1] * sum[1], 2.0 * (sum[0] * sum[2] + sum[1] * sum[3]))
            }
        }
    }
}
