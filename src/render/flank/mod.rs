//! Front-lit flanks of worn inserts, with their truth.
//!
//! In: [`FlankScene`] (pose of the edge, wear, surface, light, sensor), by hand or [drawn at
//! random](FlankScene::drawn). Out: a frame, the mask of the land and the width of the land in
//! every place along the edge ([`FlankTruth`]). `noise` is the lattice noise of the surfaces,
//! `wear` the land's border, `surface` the light that a place of the flank sends into the camera,
//! `flank_frame` makes pixels of it. A further kind of wear is a term of `wear`, one more look of a
//! surface a term of `surface`.

mod drawn;
mod flank_frame;
mod noise;
mod settings;
mod surface;
mod wear;

pub(crate) use flank_frame::{FlankTruth, below_edge_um, flank_truth, render_flank};
pub(crate) use settings::FlankScene;
