//! Gaussian blur: F(d) = Φ(d/σ).
//!
//! Lens, defocus and motion add as variances:
//!
//! ```text
//! σ² = σ_lens² + (y·NA_eff)²/4 + (v·t)²/12,   NA_eff = min(NA, NA_illumination)
//! ```
//!
//! y the distance out of focus, v the speed of the edge across itself, t the exposure. The terms
//! are the variances of a uniform disc of radius y·NA_eff seen edge-on, and of a box. Valid while
//! no single term but the first dominates; otherwise use [`super::Shifts::disc`] and
//! [`super::Shifts::uniform`] on the table.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use statrs::function::erf::erfc;

use super::table::EdgeSpread;
use crate::numerics::distributions::phi_pdf;
use crate::render::error::{RenderError, within};

/// Reach of the table in σ before its ends fade: the rest is 2e-10.
const REACH: f64 = 6.25 / 0.8;

/// Largest error of the table's interpolation, share of full intensity.
const TOLERANCE: f64 = 1e-8;

/// A Gaussian edge in units of the object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct GaussianBlur {
    /// Standard deviation of the blur by lens and sensor, µm on the object.
    pub lens_sigma_um: f64,
    /// Distance of the edge from the plane of focus, mm.
    pub defocus_mm: f64,
    /// Effective numerical aperture, the smaller one of lens and light.
    pub effective_na: f64,
    /// Path of the edge across itself during the exposure, µm.
    pub motion_um: f64,
}

impl Default for GaussianBlur {
    /// 1.2 px of 15.26 µm, in focus, at rest.
    fn default() -> Self {
        Self { lens_sigma_um: 18.3, defocus_mm: 0.0, effective_na: 0.02, motion_um: 0.0 }
    }
}

impl GaussianBlur {
    /// Checks every value against its range.
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        within("optics.esf.gaussian_blur.lens_sigma_um", self.lens_sigma_um, 1e-3, 1e4)?;
        within("optics.esf.gaussian_blur.defocus_mm", self.defocus_mm, -1e3, 1e3)?;
        within("optics.esf.gaussian_blur.effective_na", self.effective_na, 0.0, 0.5)?;
        within("optics.esf.gaussian_blur.motion_um", self.motion_um, 0.0, 1e4)
    }

    /// Standard deviation of all terms together, µm.
    pub(crate) fn sigma_um(&self) -> f64 {
        let defocus_um = self.defocus_mm * 1e3 * self.effective_na / 2.0;
        let motion_um = self.motion_um / 12f64.sqrt();
        (self.lens_sigma_um.powi(2) + defocus_um.powi(2) + motion_um.powi(2)).sqrt()
    }

    /// The table.
    ///
    /// # Errors
    /// Refuses values outside their ranges.
    pub(crate) fn edge_spread(&self) -> Result<EdgeSpread, RenderError> {
        self.check()?;
        let sigma = self.sigma_um();
        EdgeSpread::tabulate(-REACH * sigma, REACH * sigma, TOLERANCE, |d| {
            let (light, density) = gaussian(d / sigma);
            (light, density / sigma)
        })
    }
}

/// Φ(u) and φ(u); the reference computes Φ in another way (libm's erf).
pub(crate) fn gaussian(u: f64) -> (f64, f64) {
    (0.5 * erfc(-u / std::f64::consts::SQRT_2), phi_pdf(u))
}
