//! Contamination: what lies between light and camera, or on the shaft, and is not the part.
//!
//! Three kinds by how they move. On the protective window (droplets, specks, scratches): fixed in
//! the image, the same in every frame. In the air (mist, droplets, chips): drawn anew for every
//! frame. On the shaft (films): fixed to the body, they turn with it and raise the silhouette
//! ([`AdheringFilms`]). The first two are a transmission 0..1.. that multiplies the light of every
//! pixel ([`TransmissionMap`]); the [`mask`] of every pixel states what touches it.
//!
//! Telecentric and geometric: an opaque disc of radius a at the distance y from the plane of focus
//! is folded with the disc of confusion of radius b = |y|·NA, so that its shade grows and pales.
//! Numbers are Poisson, sizes lognormal, places uniform; all drawn by seed. Multiplying the
//! finished image is exact where a shade is smooth over the width of the edge spread; a sharp one
//! that crosses the shaft's edge in the plane of focus is blurred by itself, not with the edge.
//!
//! In: the `[contamination]` table (`settings`) and the field's geometry. Out:
//! [`ContaminationModel`], which gives the packed factors of a frame and the films near a field.
//! `field` draws, `shading` lays shades over a band of `tiles`, `bands` packs them, `map` holds
//! them unpacked, with what touches each pixel. A new kind is a table in `settings`, its draw in
//! `field` and its shade in `shading`.

mod adhering_films;
mod bands;
#[allow(clippy::module_inception, reason = "the file of the folder's main type")]
mod contamination;
mod field;
mod map;
pub mod mask;
mod settings;
mod shading;
pub mod shapes;
mod tiles;

pub use adhering_films::{AdheringFilms, Film};
pub use contamination::{ContaminationModel, Rise, RisenEdge, mark_rise};
pub use field::{ContaminationField, FieldGeometry};
pub use map::TransmissionMap;
pub use settings::{
    AirDroplets, Chips, Contamination, Dirt, Films, Mist, Scratches, SizeDistribution, WindowDroplets,
};
pub use tiles::TransmissionRequest;
