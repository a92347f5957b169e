//! Lens and edge spread: the `[optics]` table.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::edge_spread::{
    CylinderEdge, GrazingReflection, LaserShadow, MeasuredEsf, PartiallyCoherentEdge,
    check_beside_aberrations,
};
use super::lens::{Distortion, FieldAberrations, FieldCurvature, aberrations};
use crate::render::error::{RenderError, within};

/// The family of the edge-spread function. One table in the config: `[optics.esf.gaussian]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum Esf {
    /// Gaussian blur.
    Gaussian(GaussianEsf),
    /// Diffraction by a circular pupil in partially coherent light.
    PartiallyCoherent(PartiallyCoherentEdge),
    /// The limb of a thick round part in the same light: its edge lies outside the body.
    Cylinder(CylinderEdge),
    /// Collimated light on the bare sensor: a laser shadow.
    Fresnel(LaserShadow),
    /// A measured edge.
    Measured(MeasuredEsf),
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

impl Esf {
    /// Checks every value of the family against its range.
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        match self {
            Self::Gaussian(g) => within("optics.esf.gaussian.sigma_px", g.sigma_px, 0.25, 20.0),
            Self::PartiallyCoherent(p) => p.check(),
            Self::Cylinder(c) => c.check(),
            Self::Fresnel(f) => f.check(),
            Self::Measured(m) => m.edge().map(drop),
        }
    }
}

/// A lens that sees in perspective: a pinhole before the axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Entocentric {
    /// From the pinhole (entrance pupil) to the axis of rotation, mm; `optics.magnification` holds
    /// in the axis' plane.
    pub distance_mm: f64,
}

impl Default for Entocentric {
    fn default() -> Self {
        Self { distance_mm: 200.0 }
    }
}

/// Lens and edge spread.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Optics {
    /// Lateral magnification in the plane of the axis, image size over object size.
    pub magnification: f64,
    /// How light passes into shadow.
    pub esf: Esf,
    /// Effective aperture (the smaller of lens and illumination) with which an edge out of focus
    /// blurs: σ² grows by (y·NA)²/4 on the object, a measured edge by a disc of radius y·NA; 0
    /// leaves focus out. Partially coherent and laser light have their own.
    pub defocus_na: f64,
    /// Residual telecentricity: angle of the chief ray to the optical axis at half the sensor's
    /// diagonal from the centre, mrad; positive where what comes closer looks larger. It grows in
    /// proportion to the distance from the centre.
    pub telecentricity_mrad: f64,
    /// Perspective; absent for a telecentric lens.
    pub entocentric: Option<Entocentric>,
    /// Radial and tangential distortion.
    pub distortion: Distortion,
    /// Where the lens is in focus over the field; absent where it is a plane square to the axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub field_curvature: Option<FieldCurvature>,
    /// Spherical aberration, coma and astigmatism by the height in the field, for
    /// `partially_coherent`; absent for a lens without.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub aberrations: Vec<FieldAberrations>,
    /// A file `lens.toml` beside the config, as `calibrate --lens` writes it, in place of
    /// `distortion`, `telecentricity_mrad`, `field_curvature` and `aberrations`; its values take
    /// its place in the resolved config.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lens_file: Option<String>,
    /// Glancing reflection of a polished shaft in diffuse light; absent for a dull one.
    pub reflection: Option<GrazingReflection>,
}

impl Default for Optics {
    /// Ø25 fills 80 % of 2048 rows: 15.26 µm per pixel on the object.
    fn default() -> Self {
        Self {
            magnification: 0.226,
            esf: Esf::default(),
            defocus_na: 0.02,
            telecentricity_mrad: 0.0,
            entocentric: None,
            distortion: Distortion::default(),
            field_curvature: None,
            aberrations: Vec::new(),
            lens_file: None,
            reflection: None,
        }
    }
}

impl Optics {
    /// Checks every value against its range.
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        within("optics.magnification", self.magnification, 1e-3, 100.0)?;
        within("optics.defocus_na", self.defocus_na, 0.0, 1.0)?;
        within("optics.telecentricity_mrad", self.telecentricity_mrad, -550.0, 550.0)?;
        if let Some(e) = self.entocentric {
            within("optics.entocentric.distance_mm", e.distance_mm, 1.0, 1e6)?;
            if self.telecentricity_mrad != 0.0 {
                let right = "is for a telecentric lens: leave it 0 beside optics.entocentric";
                return Err(RenderError::setting(
                    "optics.telecentricity_mrad",
                    &self.telecentricity_mrad,
                    right,
                ));
            }
        }
        if let Some(name) = &self.lens_file {
            let right = "was not read: a config is loaded from a file to find the ones it names";
            return Err(RenderError::setting("optics.lens_file", name, right));
        }
        if let Esf::Cylinder(_) = self.esf {
            self.check_beside_limb()?;
        }
        self.distortion.check()?;
        self.field_curvature.map_or(Ok(()), |curvature| curvature.check())?;
        self.check_aberrations()?;
        if let Some(r) = &self.reflection {
            r.check()?;
        }
        self.esf.check()
    }

    /// Refuses aberrations out of range, and beside a family that has no pupil to put them in.
    fn check_aberrations(&self) -> Result<(), RenderError> {
        if self.aberrations.is_empty() {
            return Ok(());
        }
        aberrations::check(&self.aberrations)?;
        let rows = format!("{} rows", self.aberrations.len());
        let Esf::PartiallyCoherent(edge) = &self.esf else {
            let right = "need optics.esf.partially_coherent: no other family has them";
            return Err(RenderError::setting("optics.aberrations", &rows, right));
        };
        if self.reflection.is_some() {
            let right = "stand beside optics.reflection, which is not followed through them: leave out one of the two";
            return Err(RenderError::setting("optics.aberrations", &rows, right));
        }
        check_beside_aberrations(edge)
    }

    /// Refuses what the limb of a cylinder already contains or does not follow.
    fn check_beside_limb(&self) -> Result<(), RenderError> {
        if let Some(r) = &self.reflection {
            let right = "adds mirrored light that optics.esf.cylinder contains: leave out one of the two";
            return Err(RenderError::setting("optics.reflection.polished_share", &r.polished_share, right));
        }
        if let Some(e) = &self.entocentric {
            let right = "moves the limb out of the plane of the axis, which optics.esf.cylinder does not follow: it is for telecentric lenses";
            return Err(RenderError::setting("optics.entocentric.distance_mm", &e.distance_mm, right));
        }
        Ok(())
    }
}
