//! What a user sets about the edge-spread function: one family, its own table in the config.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::error::{RenderError, within};

/// The family of the edge-spread function. One table in the config: `[optics.esf.gaussian]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum Esf {
    /// Gaussian blur.
    Gaussian(GaussianEsf),
    /// Diffraction by a circular pupil in partially coherent light.
    PartiallyCoherent(PartiallyCoherentEsf),
    /// Collimated light on the bare sensor: a laser shadow.
    Fresnel(FresnelEsf),
    /// A measured edge.
    Table(TableEsf),
}

impl Default for Esf {
    fn default() -> Self {
        Self::Gaussian(GaussianEsf::default())
    }
}

/// A Gaussian line-spread function; the pixel's area comes on top of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GaussianEsf {
    /// Standard deviation of the blur in the image, px.
    pub sigma_px: f64,
}

impl Default for GaussianEsf {
    fn default() -> Self {
        Self { sigma_px: 1.2 }
    }
}

/// Edge image of a lens with a circular pupil; at S ≤ .75 the 50 % point lies .1 λ/NA in the light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PartiallyCoherentEsf {
    /// Object-side numerical aperture of the lens.
    pub numerical_aperture: f64,
    /// S = NA of the illumination over NA of the lens; 0 is coherent.
    pub coherence_ratio: f64,
    /// Wavelength, nm.
    pub wavelength_nm: f64,
    /// Distance of the edge from the focal plane, µm.
    pub defocus_um: f64,
}

impl Default for PartiallyCoherentEsf {
    /// A telecentric lens of NA .02 in green light.
    fn default() -> Self {
        Self { numerical_aperture: 0.02, coherence_ratio: 0.5, wavelength_nm: 525.0, defocus_um: 0.0 }
    }
}

impl PartiallyCoherentEsf {
    fn check(&self) -> Result<(), RenderError> {
        within("optics.esf.partially_coherent.numerical_aperture", self.numerical_aperture, 1e-4, 0.9)?;
        within("optics.esf.partially_coherent.coherence_ratio", self.coherence_ratio, 0.0, 4.0)?;
        within("optics.esf.partially_coherent.wavelength_nm", self.wavelength_nm, 100.0, 20000.0)?;
        // Four depths λ/NA²; beyond it the quadrature of the phase would no longer hold.
        let depth_um = self.wavelength_nm * 1e-3 / self.numerical_aperture.powi(2);
        within("optics.esf.partially_coherent.defocus_um", self.defocus_um, -4.0 * depth_um, 4.0 * depth_um)
    }
}

/// Shadow of an edge in collimated light without a lens.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FresnelEsf {
    /// Centre wavelength, nm.
    pub wavelength_nm: f64,
    /// Full width of the band at half maximum, nm; 0 is monochromatic.
    pub bandwidth_nm: f64,
    /// From the edge to the sensor, mm.
    pub distance_mm: f64,
}

impl Default for FresnelEsf {
    /// A red LED close to the part.
    fn default() -> Self {
        Self { wavelength_nm: 650.0, bandwidth_nm: 20.0, distance_mm: 20.0 }
    }
}

impl FresnelEsf {
    fn check(&self) -> Result<(), RenderError> {
        within("optics.esf.fresnel.wavelength_nm", self.wavelength_nm, 100.0, 20000.0)?;
        within("optics.esf.fresnel.bandwidth_nm", self.bandwidth_nm, 0.0, 0.3 * self.wavelength_nm)?;
        within("optics.esf.fresnel.distance_mm", self.distance_mm, 0.01, 1e4)
    }
}

/// A measured edge-spread function.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TableEsf {
    /// Distances into the light from the geometric edge, image px, ascending.
    pub distance_px: Vec<f64>,
    /// Share of the light there; 0 at the first, 1 at the last distance.
    pub light: Vec<f64>,
    /// Whether the light may fall again further into the light (ripples).
    pub may_ripple: bool,
}

/// How far a measured edge may miss 0 and 1 at its ends.
const NORMALISED: f64 = 2e-3;

impl TableEsf {
    /// Linear between the points, held beyond them.
    pub(super) fn at(&self, distance_px: f64) -> f64 {
        let after = self.distance_px.partition_point(|d| *d <= distance_px);
        match (after.checked_sub(1), self.distance_px.get(after)) {
            (Some(i), Some(next)) => {
                let t = (distance_px - self.distance_px[i]) / (next - self.distance_px[i]);
                self.light[i] + t * (self.light[after] - self.light[i])
            }
            (None, _) => 0.0,
            (Some(_), None) => 1.0,
        }
    }

    fn check(&self) -> Result<(), RenderError> {
        let n = self.distance_px.len();
        let refuse = |key, right: &str| Err(RenderError::setting(key, &format!("{n} points"), right));
        if n < 4 || n != self.light.len() {
            return refuse("optics.esf.table.light", "needs as many values as distance_px, at least 4");
        }
        let finite = self.distance_px.iter().chain(&self.light).all(|v| v.is_finite());
        if !finite || self.distance_px.windows(2).any(|w| w[1] - w[0] < 1e-3) {
            return refuse("optics.esf.table.distance_px", "must be finite and ascend by .001 px or more");
        }
        if self.light[0].abs() > NORMALISED || (self.light[n - 1] - 1.0).abs() > NORMALISED {
            return refuse(
                "optics.esf.table.light",
                "must be normalised: 0 at the first, 1 at the last distance",
            );
        }
        if !self.may_ripple && !self.light.is_sorted() {
            return refuse("optics.esf.table.light", "falls; set may_ripple = true if that is meant");
        }
        Ok(())
    }
}

impl Esf {
    /// Checks every value of the family against its range.
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right.
    pub fn check(&self) -> Result<(), RenderError> {
        match self {
            Self::Gaussian(g) => within("optics.esf.gaussian.sigma_px", g.sigma_px, 0.25, 20.0),
            Self::PartiallyCoherent(p) => p.check(),
            Self::Fresnel(f) => f.check(),
            Self::Table(t) => t.check(),
        }
    }
}
