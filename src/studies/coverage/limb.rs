//! Round parts of unknown material under a film of unknown thickness, out of focus: the rows of a
//! limb's difference, drawn and declared.
//!
//! Masters of dry, lapped steel stand in focus. The part's material is drawn by its extinction, its
//! film by its thickness, its axis by its depth, each evenly within the limits that its row of the
//! budget states; what follows is physics of the renderer. The declared `[limb]` table is the one
//! that `optics limb` prints for the same head, masters and part.

use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::gauge::calibration::{Finish, LimbDifference};
use crate::gauge::{EdgeRoom, GaugeSettings};
use crate::render::RenderError;
use crate::render::optics::edge_spread::CylinderEdge;
use crate::render::optics::edge_spread::cylinder::Material;
use crate::render::settings::{Esf, SetupSettings};
use crate::studies::calibration::Draws;
use crate::studies::head::limb::{FittedEdge, LimbHead, Surfaces, Texture, compare};

/// Diameters of the masters and of the middle of the parts, mm.
pub(super) const MASTERS_MM: [f64; 2] = [4.0, 6.6];
const PART_MM: f64 = 5.3;

/// Limits of the part's depth, ± mm: what spindles and V-blocks hold.
pub(super) const LIMIT_DEPTH_MM: f64 = 0.3;

/// Thickness of the film and its limits, ± µm: dry to wet with oil.
const FILM_UM: (f64, f64) = (0.5, 0.5);

/// Index of the parts' surfaces: steel's refractive index, and extinctions about steel's. At mid
/// visible wavelengths the edge moves by κλ/4π (0.042 µm a unit of κ at 525 nm), so that ± 2.6
/// spread it evenly over the ± 0.11 µm that an unknown material is allowed for.
const REFRACTIVE_INDEX: f64 = 2.9;
const EXTINCTION: f64 = 3.1;
const EXTINCTION_SPREAD: f64 = 2.6;

/// The surface and depth of a scene's part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LimbPart {
    extinction: f64,
    /// Thickness of the film, µm: the part is seen with it.
    pub(super) film_um: f64,
}

impl LimbPart {
    /// The part of a scene.
    pub(super) fn draw(draws: &mut Draws) -> Self {
        Self {
            extinction: EXTINCTION + EXTINCTION_SPREAD * draws.even(),
            film_um: FILM_UM.0 + FILM_UM.1 * draws.even(),
        }
    }

    /// The limb of this part, its axis `y_mm` before the plane of focus, in the light of `esf`.
    pub(super) fn seen_in(self, esf: &Esf, y_mm: f64) -> Esf {
        let Esf::Cylinder(light) = esf else { return esf.clone() };
        Esf::Cylinder(CylinderEdge {
            defocus_mm: light.defocus_mm + y_mm,
            refractive_index: Some(REFRACTIVE_INDEX),
            extinction: Some(self.extinction),
            film_um: self.film_um,
            ..light.clone()
        })
    }
}

/// Light of a ratio of coherence before dry steel.
pub(super) fn light(coherence_ratio: f64) -> CylinderEdge {
    CylinderEdge { coherence_ratio, extra_sigma_um: 5.0, ..CylinderEdge::default() }
}

/// Light, masters and parts in words.
pub(super) fn in_words(coherence_ratio: f64) -> String {
    let light = light(coherence_ratio);
    format!(
        "NA {}, coherence {coherence_ratio}; masters of steel, extinction {EXTINCTION} +- {EXTINCTION_SPREAD}, \
         film {} +- {} um, axis +- {LIMIT_DEPTH_MM} mm",
        light.na, FILM_UM.0, FILM_UM.1
    )
}

/// Tables by the ratio of coherence: each is the same for every scene of its class.
static TABLES: Mutex<Vec<(f64, LimbDifference)>> = Mutex::new(Vec::new());

fn tables() -> MutexGuard<'static, Vec<(f64, LimbDifference)>> {
    TABLES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The declared difference of the parts from the masters, before this setup and gauge.
///
/// # Errors
/// Limbs that cannot be computed or fitted.
pub(super) fn difference(
    coherence_ratio: f64,
    setup: &SetupSettings,
    gauge: &GaugeSettings,
) -> Result<LimbDifference, RenderError> {
    if let Some((_, limb)) = tables().iter().find(|(of, _)| *of == coherence_ratio) {
        return Ok(*limb);
    }
    // Computed without the lock: a thread that waits for others' work may take up another scene.
    let half_px = EdgeRoom::of(gauge, 1.0).beside_px as usize;
    let surfaces = Surfaces {
        masters_mm: MASTERS_MM.to_vec(),
        masters_material: Material::Steel,
        part_material: None,
        masters_finish: Finish::Lapped,
        certified_by_contact: false,
        part_texture: Texture::Roughness(0.0),
        film_um: FILM_UM,
        range_mm: (3.8, 6.8),
        masters_y_mm: 0.0,
    };
    let failed = |e: crate::studies::head::HeadError| RenderError::Field { what: e.to_string() };
    let head = LimbHead::before(setup, PART_MM, half_px, FittedEdge::Optics).map_err(failed)?;
    let limb = compare(&head, &surfaces).map_err(failed)?.limb;
    tables().push((coherence_ratio, limb));
    Ok(limb)
}
