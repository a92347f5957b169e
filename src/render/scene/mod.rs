//! Scene: one instant of a shaft before a camera, and the exposure as a sum of instants.
//!
//! In: a shaft, an [`OpticalBench`] (the true optical setup, drawn once from settings and seed) and a [`FrameRequest`]
//! (spindle angle, axial field, seed of the noise). Out: the true rows of both edges of every column, and the
//! [`Job`](super::params::Job) that the kernel computes.
//!
//! Steps of a frame: `exposure` (the instants of the shutter), `scene` (the outline of each instant to rows of the
//! image), `column_profiles` (columns whose edge is no straight line within the blur), `contamination_layer` (what
//! dims the light or raises the silhouette). A new effect on a frame is a step with a file of its own.

pub(crate) mod column_profiles;
pub(crate) mod contamination_layer;
pub(crate) mod exposure;
#[allow(clippy::module_inception, reason = "the file of the folder's main type")]
pub(crate) mod scene;
pub(crate) mod true_optics;

pub use scene::{FrameRequest, Scene};
pub use true_optics::OpticalBench;
