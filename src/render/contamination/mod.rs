//! Contamination between light and camera, and on the shaft.
//!
//! There are three kinds by their motion. On the protective window (droplets, specks, scratches):
//! fixed in the image, the same in every frame. In the air (mist, droplets, chips): drawn anew for
//! every frame. On the shaft (films): fixed to the body, they turn with it and raise the silhouette
//! (`AdheringFilms`). The first two are a transmission 0..1.. that multiplies the light of every
//! pixel (`TransmissionMap`); the `mask` of every pixel states which kinds affect it.
//!
//! Telecentric and geometric: an opaque disc of radius a at the distance y from the plane of focus
//! is convolved with the disc of confusion of radius b = |y|·NA, so that its shade becomes wider
//! and weaker. Numbers are Poisson, sizes lognormal, places uniform; all drawn by seed. Multiplying
//! the finished image is exact where a shade is smooth over the width of the edge spread; a sharp
//! one that crosses the shaft's edge in the plane of focus is blurred separately, not together with
//! the edge.
//!
//! In: the `[contamination]` table (`settings`) and the field's geometry. Out:
//! `ContaminationModel`, which returns the packed factors of a frame and the films near a field.
//! `field` draws, `shading` multiplies shades onto a band of `tiles`, `bands` packs them, `map`
//! holds them unpacked, with the mask of each pixel. A new kind is a table in `settings`, its draw
//! in `field` and its shade in `shading`.

mod adhering_films;
mod bands;
#[allow(clippy::module_inception, reason = "the file of the folder's main type")]
mod contamination;
mod field;
mod map;
pub(crate) mod mask;
mod settings;
mod shading;
pub(crate) mod shapes;
mod tiles;

pub use self::{
    contamination::ContaminationModel,
    settings::{
        AirDroplets, Chips, Contamination, Dirt, Films, Mist, Scratches, SizeDistribution, WindowDroplets,
    },
};
#[cfg(test)]
pub(crate) use adhering_films::{AdheringFilms, Film};
pub(crate) use contamination::{Rise, RisenEdge, mark_rise};
pub(crate) use field::{ContaminationField, FieldGeometry};
pub(crate) use map::TransmissionMap;
pub(crate) use tiles::TransmissionRequest;
