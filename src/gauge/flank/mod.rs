//! The worn land of a front-lit flank: a frame to VB along the edge, and ISO 3685's zones.
//!
//! `reference` finds the straight border of what has detail, `lift` the cutting edge above it where
//! a smooth land lies between, `edge` follows it
//! and fits the curve of the new edge, `strip` rectifies the image along that curve (rows at right
//! angles to it, 2 µm apart). A `forest` gives every pixel the probability of being land from its
//! `features` and, by second trees, the `context` that the first ones found; the `path` of least
//! cost through these is the land's border (`land`), its distance from the reference VB(s). `zones`
//! divides the worn length, `measurement` puts it together with u. `labelled` trains a forest on
//! flanks with masks, `paper` measures as a published paper does.
//!
//! In: a frame, [`FlankSettings`], a [`LandModel`]: a [`Forest`] ([`shipped`]: trained on rendered
//! flanks alone) or, with the feature `onnx`, a `network` of the user's.
//! Out: [`FlankMeasurement`] (`result`) in µm, or a [`FlankError`]. One more feature of a pixel is
//! a line of `features`, and the shipped forest is trained anew.

mod context;
mod edge;
mod envelope;
mod error;
mod features;
pub(crate) mod forest;
pub(crate) mod labelled;
mod land;
mod lift;
pub(crate) mod limits;
mod located;
mod measurement;
mod model;
#[cfg(feature = "onnx")]
pub(crate) mod network;
pub(crate) mod paper;
mod path;
mod raster;
mod reference;
mod result;
mod settings;
mod strip;
mod zones;

pub(crate) use context::CONTEXT;
pub(crate) use error::FlankError;
pub(crate) use features::FEATURES;
pub(crate) use forest::Forest;
pub(crate) use labelled::{Drawn, Labelled, drawn, errors_um, train};
pub(crate) use located::{KnownEdge, locate};
pub(crate) use measurement::measure_flank;
pub(crate) use model::LandModel;
pub(crate) use raster::Raster;
pub(crate) use result::{FlankBudget, FlankMeasurement};
pub(crate) use settings::{CornerSide, FlankSettings, FlankSide};
pub(crate) use strip::normalised;

/// The forest that the program brings along, trained on rendered flanks alone: `tool render-flank
/// --random 240`, then `tool train --test` with 200 others (`--seed 5001`). Its file states its
/// errors on those; errors about the limits of wear, and on real flanks, are larger and are stated
/// instead.
///
/// # Errors
/// None but for a program whose features are no longer the forest's.
pub(crate) fn shipped() -> Result<Forest, FlankError> {
    let read = forest::file::read(include_bytes!("rendered.forest"), (FEATURES, CONTEXT));
    let mut forest = read.map_err(FlankError::Model)?;
    let limits = limits::FlankLimits::get();
    let facts = &mut forest.facts;
    facts.vb_error_um = facts.vb_error_um.max(limits.shipped_vb_um);
    facts.vb_max_error_um = facts.vb_max_error_um.max(limits.shipped_vb_max_um);
    Ok(forest)
}
