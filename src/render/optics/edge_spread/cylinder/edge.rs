//! The `[optics.esf.cylinder]` table: lens, light and surface of a round part, what is refused of
//! them, and the edge-spread function of its limb.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::airy::C;
use super::image::{Limb, Samples, View, image};
use super::material::Material;
use super::surface::Surface;
use crate::render::error::{RenderError, within};
use crate::render::optics::edge_spread::partial::PartiallyCoherentEdge;
use crate::render::optics::edge_spread::shifts::Shifts;
use crate::render::optics::edge_spread::table::EdgeSpread;
use crate::render::optics::lens::aberrations::PupilPath;

/// Largest error of the table's interpolation, share of full intensity: it moves the edge by less
/// than .001 µm. Many radii and distances have to fit into memory.
const TOLERANCE: f64 = 1e-5;

/// Smallest diameter, mm, and the smallest M: below, terms of order 1/M² that the integral leaves
/// out count, and thin wires are imaged well by a thin screen.
const LEAST_DIAMETER_MM: f64 = 0.5;
const LEAST_M: f64 = 11.0;

/// Largest phase that the limb's cubic phase leaves out at the rim of the aperture, kRθ⁵/120 =
/// M³θ⁵/60: it moves the light there by 2 %, where less than a tenth of it passes.
const LARGEST_PHASE: f64 = 0.02;

/// Absorption 2κkR above which no light leaves the body again: e^(-7) = 1e-3.
const OPAQUE: f64 = 7.0;

/// Smallest |m² - 1|, below which the surface has no impedance of its own.
const LEAST_CONTRAST: f64 = 0.5;

/// Direction of the electric field of the light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Polarisation {
    /// Both in equal parts: a LED.
    #[default]
    Unpolarised,
    /// Along the part's axis (TM).
    AlongAxis,
    /// Across the part's axis (TE).
    AcrossAxis,
}

/// Lens, light and surface of a round part; `defocus_mm` has a sign.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CylinderEdge {
    /// Numerical aperture of the lens on the side of the object.
    #[serde(rename = "numerical_aperture")]
    pub na: f64,
    /// S = NA of the light over NA of the lens, 0 (coherent) to 3.
    pub coherence_ratio: f64,
    /// Wavelength, nm.
    pub wavelength_nm: f64,
    /// Distance of the axis from the plane of focus, mm, positive towards the camera; the sign
    /// counts.
    pub defocus_mm: f64,
    /// Reach of the table to either side of the edge, in λ/NA; beyond it the light is level.
    pub reach: f64,
    /// Standard deviation of further blur (aberration, sensor), µm on the object.
    pub extra_sigma_um: f64,
    /// What the part is made of.
    pub material: Material,
    /// Refractive index n of the surface, with `extinction` in place of `material`'s.
    pub refractive_index: Option<f64>,
    /// Extinction coefficient κ of the surface, with `refractive_index`.
    pub extinction: Option<f64>,
    /// Thickness of a transparent film (oil, coolant) on the part, µm; diameters are those of its
    /// outside. 0 for none.
    pub film_um: f64,
    /// Refractive index of the film.
    pub film_index: f64,
    /// Rq of the roughness around the part (along the light) about its mean line, µm.
    pub roughness_um: f64,
    /// Correlation length of that roughness, µm, at least 2.
    pub correlation_um: f64,
    /// Direction of the electric field.
    pub polarisation: Polarisation,
}

impl Default for CylinderEdge {
    /// Smooth dry steel, NA 0.02, half-filled pupil, green light.
    fn default() -> Self {
        Self {
            na: 0.02,
            coherence_ratio: 0.5,
            wavelength_nm: 525.0,
            defocus_mm: 0.0,
            reach: 20.0,
            extra_sigma_um: 0.0,
            material: Material::default(),
            refractive_index: None,
            extinction: None,
            film_um: 0.0,
            film_index: 1.47,
            roughness_um: 0.0,
            correlation_um: 10.0,
            polarisation: Polarisation::default(),
        }
    }
}

impl CylinderEdge {
    /// The lens and the light of a thin edge, before a limb of dry, smooth steel.
    pub(crate) fn of_lens(p: &PartiallyCoherentEdge) -> Self {
        Self {
            na: p.na,
            coherence_ratio: p.coherence_ratio,
            wavelength_nm: p.wavelength_nm,
            defocus_mm: p.defocus_mm,
            reach: p.reach,
            extra_sigma_um: p.extra_sigma_um,
            ..Self::default()
        }
    }

    /// Checks every value against its range; what depends on the radius is checked by
    /// [`Self::edge_spread`].
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        within("optics.esf.cylinder.numerical_aperture", self.na, 1e-3, 0.2)?;
        within("optics.esf.cylinder.coherence_ratio", self.coherence_ratio, 0.0, 3.0)?;
        within("optics.esf.cylinder.wavelength_nm", self.wavelength_nm, 100.0, 20_000.0)?;
        // The nodes of the source grow with the reach.
        within("optics.esf.cylinder.reach", self.reach, 4.0, 60.0)?;
        within("optics.esf.cylinder.extra_sigma_um", self.extra_sigma_um, 0.0, 1e4)?;
        // Geometric blur of 2·z·λ/NA has to stay within the reach.
        let largest_mm = 0.25 * self.reach * self.unit_um() / self.na * 1e-3;
        within("optics.esf.cylinder.defocus_mm", self.defocus_mm, -largest_mm, largest_mm)?;
        within("optics.esf.cylinder.film_um", self.film_um, 0.0, 10.0)?;
        within("optics.esf.cylinder.film_index", self.film_index, 1.1, 2.5)?;
        within("optics.esf.cylinder.roughness_um", self.roughness_um, 0.0, 0.5)?;
        within("optics.esf.cylinder.correlation_um", self.correlation_um, 2.0, 1e3)?;
        let contrast = self.index()?.powi(2) - 1.0;
        if contrast.norm() < LEAST_CONTRAST {
            let right = "is too close to that of air: |m² - 1| must be at least 0.5";
            return Err(RenderError::setting("optics.esf.cylinder.refractive_index", &self.shown(), right));
        }
        Ok(())
    }

    /// λ/NA, µm.
    pub(crate) fn unit_um(&self) -> f64 {
        self.wavelength_nm * 1e-3 / self.na
    }

    /// The same lens and light before a thin screen.
    pub(crate) fn thin(&self) -> PartiallyCoherentEdge {
        PartiallyCoherentEdge {
            na: self.na,
            coherence_ratio: self.coherence_ratio,
            wavelength_nm: self.wavelength_nm,
            bandwidth_nm: 0.0,
            defocus_mm: self.defocus_mm,
            reach: self.reach,
            extra_sigma_um: self.extra_sigma_um,
        }
    }

    /// The image of the limb of a surface of curvature radius `radius_mm`, its axis `y_mm` nearer
    /// to the camera than `defocus_mm`; µm on the object.
    ///
    /// # Errors
    /// Refuses values outside their ranges and a radius for which the method does not hold.
    pub(crate) fn edge_spread(&self, radius_mm: f64, y_mm: f64) -> Result<EdgeSpread, RenderError> {
        self.check()?;
        self.check_radius(radius_mm)?;
        let key = (Self { defocus_mm: self.defocus_mm + y_mm, ..self.clone() }, radius_mm);
        if let Some((_, table)) = tables().iter().find(|(k, _)| *k == key) {
            return Ok(table.clone());
        }
        let table = key.0.computed(radius_mm)?;
        let mut kept = tables();
        if kept.len() == MOST_KEPT {
            kept.pop_front();
        }
        kept.push_back((key, table.clone()));
        Ok(table)
    }

    /// The image of a flat face along the light, a thin screen in the plane of the axis; µm on the
    /// object.
    ///
    /// # Errors
    /// Refuses values outside their ranges.
    pub(crate) fn face(&self) -> Result<EdgeSpread, RenderError> {
        self.check()?;
        self.tabulated(&image(Limb::screen(self.wavelength_nm), &self.view(), &[]))
    }

    fn computed(&self, radius_mm: f64) -> Result<EdgeSpread, RenderError> {
        let limb = Limb::new(radius_mm, self.wavelength_nm);
        let surface = self.surface()?;
        let along = match self.polarisation {
            Polarisation::Unpolarised => &[true, false][..],
            Polarisation::AlongAxis => &[true],
            Polarisation::AcrossAxis => &[false],
        };
        let boundaries: Vec<_> = along.iter().map(|along| surface.boundary(limb.k, *along)).collect();
        self.tabulated(&image(limb, &self.view(), &boundaries))
    }

    fn view(&self) -> View {
        View {
            na: self.na,
            source_na: self.na * self.coherence_ratio,
            // Seen from the axis, the plane of focus lies behind where the axis is nearer.
            focus_mm: -self.defocus_mm,
            reach_um: self.reach * self.unit_um(),
            path: PupilPath::default(),
        }
    }

    fn tabulated(&self, samples: &Samples) -> Result<EdgeSpread, RenderError> {
        let (unit, reach_um) = (self.unit_um(), self.reach * self.unit_um());
        let table = EdgeSpread::tabulate(-reach_um, reach_um, TOLERANCE, |d| samples.at(d))?;
        if self.extra_sigma_um == 0.0 {
            return Ok(table);
        }
        // The trapezoidal rule samples the table's finest ring, λ/2NA, at twelve points.
        let nodes = 41 + (12.5 * 24.0 * self.extra_sigma_um / unit).ceil() as usize;
        table.spread(&Shifts::gaussian(self.extra_sigma_um, nodes), TOLERANCE)
    }

    /// m = n + iκ: the two keys, or the material's at the wavelength.
    fn index(&self) -> Result<C, RenderError> {
        match (self.refractive_index, self.extinction) {
            (Some(n), Some(kappa)) => {
                within("optics.esf.cylinder.refractive_index", n, 0.05, 20.0)?;
                within("optics.esf.cylinder.extinction", kappa, 0.0, 50.0)?;
                Ok(C::new(n, kappa))
            }
            (None, None) => self.material.index(self.wavelength_nm).ok_or_else(|| {
                let (low, high) = self.material.range_nm();
                let right = format!(
                    "is outside the {low} to {high} nm for which the index of `{}` is tabulated: give refractive_index and extinction",
                    self.material.name()
                );
                RenderError::setting("optics.esf.cylinder.wavelength_nm", &self.wavelength_nm, right)
            }),
            (Some(n), None) => {
                let right = "needs `extinction` beside it: both replace the material's";
                Err(RenderError::setting("optics.esf.cylinder.refractive_index", &n, right))
            }
            (None, Some(kappa)) => {
                let right = "needs `refractive_index` beside it: both replace the material's";
                Err(RenderError::setting("optics.esf.cylinder.extinction", &kappa, right))
            }
        }
    }

    /// The index as a config would write it.
    fn shown(&self) -> String {
        self.index().map_or_else(|_| String::new(), |m| format!("{} + {}i", m.re, m.im))
    }

    fn surface(&self) -> Result<Surface, RenderError> {
        Ok(Surface {
            index: self.index()?,
            film_um: self.film_um,
            film_index: self.film_index,
            roughness_um: self.roughness_um,
            correlation_um: self.correlation_um,
        })
    }

    /// Refuses radii for which the method does not hold, or which light passes through.
    fn check_radius(&self, radius_mm: f64) -> Result<(), RenderError> {
        const KEY: &str = "optics.esf.cylinder";
        let limb = Limb::new(radius_mm, self.wavelength_nm);
        let diameter_mm = 2.0 * radius_mm;
        let refused = |right: String| Err(RenderError::setting(KEY, &format!("Ø{diameter_mm:.4} mm"), right));
        // NaN is refused as well.
        if !(diameter_mm >= LEAST_DIAMETER_MM && limb.m >= LEAST_M) {
            let least = (2e-3 * LEAST_M.powi(3) / limb.k * 2.0).max(LEAST_DIAMETER_MM);
            return refused(format!(
                "is too thin for the limb of a cylinder at {} nm, which holds from Ø{least:.2} mm on: take optics.esf.partially_coherent",
                self.wavelength_nm
            ));
        }
        let widest = self.na * self.coherence_ratio.max(1.0);
        if limb.m.powi(3) * widest.powi(5) / 60.0 > LARGEST_PHASE {
            let most = (60.0 * LARGEST_PHASE / limb.m.powi(3)).powf(0.2);
            return refused(format!(
                "is too thick for apertures of {widest:.4}: up to {most:.4} is right there; take optics.esf.partially_coherent with optics.reflection"
            ));
        }
        let index = self.index()?;
        let is_named = self.refractive_index.is_none();
        if !is_named && 2e3 * index.im * limb.k * radius_mm < OPAQUE {
            let least = OPAQUE / (2e3 * limb.k * radius_mm);
            return refused(format!(
                "is transparent at an extinction of {}: light passes through it, which this family leaves out; at least {least:.1e} is opaque, and so is material = \"ceramic\", which scatters",
                index.im
            ));
        }
        Ok(())
    }
}

/// Cache of the tables computed last: stacks over radius and focus of one optical setup share many.
type Kept = VecDeque<((CylinderEdge, f64), EdgeSpread)>;
static TABLES: Mutex<Kept> = Mutex::new(VecDeque::new());
const MOST_KEPT: usize = 128;

fn tables() -> MutexGuard<'static, Kept> {
    TABLES.lock().unwrap_or_else(PoisonError::into_inner)
}
