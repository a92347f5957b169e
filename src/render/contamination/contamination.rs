//! Contamination of an optical setup: one window for all frames, new air for each, films at every
//! field of the shaft.

use std::ops::Range;
use std::sync::{Mutex, OnceLock, PoisonError};

use super::adhering_films::{AdheringFilms, Film};
use super::bands::{CachedTiles, shade_packed};
use super::field::{ContaminationField, FieldGeometry};
use super::mask;
use super::settings::Contamination;
use super::tiles::TransmissionRequest;
use crate::render::error::RenderError;
use crate::render::kernel::light_map::LightMap;

/// Films are drawn in pieces of the shaft of this length, each with its own seed, mm, so that every
/// field shows the same ones.
const PIECE_MM: f64 = 10.0;

/// A rise is masked where it changes a pixel by the threshold: Δ ≈ rise/(σ√2π) of the light.
const PEAK_OF_UNIT_GAUSSIAN: f64 = 0.398_942_280_401_432_7;

/// Blur widths on either side of a raised edge that its mask covers.
const MASK_REACH: f64 = 3.0;

/// The contamination of an optical setup.
#[derive(Debug)]
pub struct ContaminationModel {
    settings: Contamination,
    geometry: FieldGeometry,
    seed: u64,
    field: ContaminationField,
    /// The window over the full sensor, computed for the first frame.
    window: OnceLock<CachedTiles>,
    spare: Mutex<Option<LightMap>>,
}

impl PartialEq for ContaminationModel {
    fn eq(&self, other: &Self) -> bool {
        (&self.settings, self.geometry, self.seed) == (&other.settings, other.geometry, other.seed)
    }
}

/// A rise of both edges of a column by films, px.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Rise {
    /// Of the upper edge, upwards.
    pub top_px: f64,
    /// Of the lower edge, downwards.
    pub bottom_px: f64,
}

impl ContaminationModel {
    /// Draws the contamination of the window; `None` where everything is clean.
    ///
    /// # Errors
    /// As [`ContaminationField::new`].
    pub(crate) fn new(
        settings: &Contamination,
        geometry: FieldGeometry,
        seed: u64,
    ) -> Result<Option<Self>, RenderError> {
        let field = ContaminationField::new(settings, geometry, seed)?;
        if settings.is_clean() {
            return Ok(None);
        }
        let (window, spare) = (OnceLock::new(), Mutex::new(None));
        Ok(Some(Self { settings: settings.clone(), geometry, seed, field, window, spare }))
    }

    /// Whether it dims any pixel; films alone do not.
    pub(crate) fn dims(&self) -> bool {
        !self.settings.is_clear()
    }

    /// Transmission of window and air in frame `frame_id` over the requested pixels, beginning at
    /// (`row`, `column`) of the sensor. Return it with [`Self::recycle`].
    ///
    /// # Errors
    /// Refuses more than a hundred thousand objects of a kind.
    pub(crate) fn transmission(
        &self,
        frame_id: u64,
        [row, column]: [usize; 2],
        request: &TransmissionRequest,
    ) -> Result<LightMap, RenderError> {
        let whole = request.size == [self.geometry.rows, self.geometry.columns];
        let air = self.field.air(frame_id)?;
        let flying = self.field.air_layers(&air, row, column);
        let mut packed = self.spare.lock().unwrap_or_else(PoisonError::into_inner).take().unwrap_or_default();
        if whole {
            let kept = self.window.get_or_init(|| {
                CachedTiles::new(&self.field.window_layers(0, 0), self.geometry.rows, self.geometry.columns)
            });
            shade_packed(Some(kept), &[flying], request, &mut packed);
        } else {
            let lying = self.field.window_layers(row, column);
            shade_packed(None, &[lying, flying], request, &mut packed);
        }
        Ok(packed)
    }

    /// Takes back a frame's factors, so that the next frame can use their memory.
    pub(crate) fn recycle(&self, packed: LightMap) {
        *self.spare.lock().unwrap_or_else(PoisonError::into_inner) = Some(packed);
    }

    /// Films that reach into `z_mm`, on a shaft of mean radius `radius_mm`.
    ///
    /// # Errors
    /// Refuses more than a hundred thousand films.
    pub(crate) fn films(&self, radius_mm: f64, z_mm: Range<f64>) -> Result<Vec<Film>, RenderError> {
        let films = &self.settings.films;
        if films.per_cm2 == 0.0 || radius_mm <= 0.0 {
            return Ok(Vec::new());
        }
        let reach = films.half_extent_um.largest_um * 1e-3;
        let piece = |z: f64| (z / PIECE_MM).floor() as i64;
        let mut found = Vec::new();
        for k in piece(z_mm.start - reach)..=piece(z_mm.end + reach) {
            let z0 = k as f64 * PIECE_MM;
            let seed = self.seed ^ (k as u64).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let drawn = AdheringFilms::draw(&self.settings, radius_mm, z0..z0 + PIECE_MM, seed)?;
            let near =
                |f: &&Film| f.z_mm + f.half_length_mm > z_mm.start && f.z_mm - f.half_length_mm < z_mm.end;
            found.extend(drawn.films().iter().filter(near).copied());
        }
        Ok(found)
    }

    /// Rises of both edges at one z by the given films, on a clean circle of `radius_mm`.
    pub(crate) fn rise(&self, films: &[Film], radius_mm: f64, z_mm: f64, angle_deg: f64) -> Rise {
        let here: Vec<Film> =
            films.iter().filter(|f| (z_mm - f.z_mm).abs() < f.half_length_mm).copied().collect();
        if here.is_empty() {
            return Rise::default();
        }
        let here = AdheringFilms::new(here);
        let pixel_mm = self.geometry.pixel_um * 1e-3;
        let at = |angle: f64| here.rise_mm(radius_mm, z_mm, angle) / pixel_mm;
        Rise { top_px: at(angle_deg), bottom_px: at(angle_deg + 180.0) }
    }
}

/// An edge displaced by a film.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RisenEdge {
    /// Row of the edge without the film.
    pub clean: f64,
    /// Its displacement, rows.
    pub rise_px: f64,
    /// Blur of the edge, px.
    pub blur_px: f64,
}

/// Marks the pixels of a column that the displacement of an edge changes.
pub(crate) fn mark_rise(mask: &mut [u8], columns: usize, column: usize, edge: RisenEdge) {
    let RisenEdge { clean, rise_px, blur_px } = edge;
    let sigma = (blur_px * blur_px + 1.0 / 12.0).sqrt();
    if rise_px.abs() * PEAK_OF_UNIT_GAUSSIAN / sigma < f64::from(mask::THRESHOLD) {
        return;
    }
    let (low, high) = (clean.min(clean + rise_px), clean.max(clean + rise_px));
    let rows = (mask.len() / columns.max(1)) as f64;
    let first = (low - MASK_REACH * sigma).ceil().clamp(0.0, rows) as usize;
    let last = (high + MASK_REACH * sigma).floor().clamp(-1.0, rows - 1.0) + 1.0;
    for row in first..last as usize {
        mask[row * columns + column] |= mask::FILM;
    }
}
