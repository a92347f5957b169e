//! Back-lit inserts: the nose of a turning tool before a light, new or worn, with its truth.
//!
//! In: [`InsertSettings`] (nose, wear, contamination, optics, light, sensor). Out: a frame and the
//! [`Truth`]: edges, centre, radii and support of the nose in f64. `shape` is the silhouette,
//! `area_blur` blurs it over its area and not by the distance of its border alone (a corner lets
//! more light in than an edge), by every family of `optics`; `insert_frame` makes pixels of it on
//! the CPU: a nose is rendered once a tool, not by the thousand. A further kind of wear is a
//! variant of [`Wear`] and its arm in `shape`.

mod area_blur;
mod insert_frame;
pub(crate) mod settings;
mod shape;

pub(crate) use insert_frame::{InsertBlur, render_insert, render_insert_through};
pub(crate) use settings::Dirt;
pub(crate) use settings::InsertSettings;
pub(crate) use settings::Wear;
pub(crate) use shape::Truth;
