//! Shift of a limb's image as the gauge reads it: place, blur and levels of the gauge's own edge
//! are fitted to the image of the limb, µm an edge outwards (a shadow too large).

use serde::Serialize;

use crate::render::optics::edge_spread::CylinderEdge;
use crate::render::settings::{Esf, GaussianEsf, Optics, SetupSettings};
use crate::studies::head::bound::GreyLevels;
use crate::studies::head::displacement::displacement;
use crate::studies::head::edge::{EdgeOptics, OpticalEdge};
use crate::studies::head::error::HeadError;
use crate::studies::head::setup::HeadSetup;

/// 10-90 % width of a Gaussian in its standard deviation.
const WIDTH_10_90: f64 = 2.563;

/// The edge that the gauge fits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum FittedEdge {
    /// That of the config's optics in focus, before the part's diameter: `[gauge.esf.optics]`.
    Optics,
    /// A Gaussian.
    Gaussian,
}

/// A head before limbs of any diameter and surface.
pub(crate) struct LimbHead {
    /// Lens, light and surface of the config.
    pub(crate) lens: CylinderEdge,
    /// Diameter of the part, mm.
    pub(crate) diameter_mm: f64,
    optics: Optics,
    fitted: FittedEdge,
    pixel_mm: f64,
    half_px: usize,
    levels: GreyLevels,
    template: OpticalEdge,
}

impl LimbHead {
    /// A head and the edge that its gauge fits.
    ///
    /// # Errors
    /// Optics without a lens and light of known aperture; a diameter whose limb cannot be computed.
    pub(crate) fn new(head: &HeadSetup, fitted: FittedEdge) -> Result<Self, HeadError> {
        let (pixel_mm, diameter_mm) = (head.optics.pixel_mm, head.diameter_mm);
        let optics = head.job.optics.clone();
        let half_px = head.half_px();
        let template = fitted.template(&optics, pixel_mm, diameter_mm, half_px)?;
        let lens = lens_of(&optics)?;
        Ok(Self { lens, diameter_mm, optics, fitted, pixel_mm, half_px, levels: head.levels, template })
    }

    /// Nominal optics and levels before a part, and the edge that its gauge fits over `half_px`
    /// pixels either side.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(crate) fn before(
        setup: &SetupSettings,
        diameter_mm: f64,
        half_px: usize,
        fitted: FittedEdge,
    ) -> Result<Self, HeadError> {
        let (pixel_mm, optics) = (setup.nominal_pixel_mm(), setup.optics.clone());
        let template = fitted.template(&optics, pixel_mm, diameter_mm, half_px)?;
        let (lens, levels) = (lens_of(&optics)?, GreyLevels::of(setup));
        Ok(Self { lens, diameter_mm, optics, fitted, pixel_mm, half_px, levels, template })
    }

    /// The same head with light of another aperture, and the edge that its gauge would fit then.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(super) fn with_ratio(&self, coherence_ratio: f64) -> Result<Self, HeadError> {
        let mut optics = self.optics.clone();
        match &mut optics.esf {
            Esf::Cylinder(c) => c.coherence_ratio = coherence_ratio,
            Esf::PartiallyCoherent(p) => p.coherence_ratio = coherence_ratio,
            _ => {}
        }
        let template = self.fitted.template(&optics, self.pixel_mm, self.diameter_mm, self.half_px)?;
        let lens = CylinderEdge { coherence_ratio, ..self.lens.clone() };
        Ok(Self { lens, optics, template, ..*self })
    }

    /// Shift of the limb of a part of `diameter_mm`, its axis `axis_y_mm` before the plane of
    /// focus, µm an edge outwards.
    ///
    /// # Errors
    /// A limb that cannot be computed, or not be fitted.
    pub(crate) fn shift_um(
        &self,
        limb: &CylinderEdge,
        diameter_mm: f64,
        axis_y_mm: f64,
    ) -> Result<f64, HeadError> {
        let seen = at(&self.optics, Esf::Cylinder(limb.clone()), self.pixel_mm, diameter_mm, axis_y_mm)?;
        let seen = seen.over_pixels(self.half_px, 1.0, 0.0);
        displacement(&self.template, &seen, self.half_px, &self.levels)
            .map(|found| 1e3 * self.pixel_mm * found.into_light_px)
            .ok_or(HeadError::NotFitted { diameter_mm, axis_y_mm })
    }
}

impl FittedEdge {
    /// The edge in focus.
    fn template(
        self,
        optics: &Optics,
        pixel_mm: f64,
        diameter_mm: f64,
        half_px: usize,
    ) -> Result<OpticalEdge, HeadError> {
        if self == Self::Optics {
            let own = EdgeOptics { optics: optics.clone(), pixel_mm, radius_mm: 0.5 * diameter_mm };
            return Ok(own.at(0.0)?);
        }
        let own = at(optics, Esf::Cylinder(lens_of(optics)?), pixel_mm, diameter_mm, 0.0)?;
        let width_px = own.width_10_90_px(half_px).unwrap_or(WIDTH_10_90);
        let esf = Esf::Gaussian(GaussianEsf { sigma_px: width_px / WIDTH_10_90 });
        at(&Optics { defocus_na: 0.0, ..optics.clone() }, esf, pixel_mm, diameter_mm, 0.0)
    }
}

/// The edge of optics with another family in them; mirrored light is part of the limb.
fn at(
    optics: &Optics,
    esf: Esf,
    pixel_mm: f64,
    diameter_mm: f64,
    axis_y_mm: f64,
) -> Result<OpticalEdge, HeadError> {
    let optics = Optics { esf, reflection: None, ..optics.clone() };
    Ok(EdgeOptics { optics, pixel_mm, radius_mm: 0.5 * diameter_mm }.at(axis_y_mm)?)
}

/// Lens and light of a config before a round part of dry, smooth steel where it states no surface.
fn lens_of(optics: &Optics) -> Result<CylinderEdge, HeadError> {
    let no_lens = |family| HeadError::NoLimb {
        family,
        why: "states no aperture of lens and light, which the limb's image follows from: take \
              [optics.esf.cylinder] with numerical_aperture, coherence_ratio and wavelength_nm",
    };
    match &optics.esf {
        Esf::Cylinder(c) => Ok(c.clone()),
        Esf::PartiallyCoherent(p) => Ok(CylinderEdge::of_lens(p)),
        Esf::Gaussian(_) => Err(no_lens("gaussian")),
        Esf::Measured(_) => Err(no_lens("measured")),
        Esf::Fresnel(_) => Err(no_lens("fresnel")),
    }
}
