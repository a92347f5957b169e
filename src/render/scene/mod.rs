//! Scene: one instant of a shaft in front of a camera, and the exposure as a sum of instants.
//!
//! In: a shaft, an [`OpticalSetup`] (the true optical setup, drawn once from settings and seed) and
//! a [`FrameRequest`] (spindle angle, axial field, seed of the noise). Out: the true rows of both
//! edges of every column, and the [`Job`](super::kernel::job::Job) that the kernel computes.
//!
//! `frame_job` takes the steps of a frame one after the other: `exposure` (the instants of the
//! exposure, with the outline of each in rows of the image), `contamination_layer` (films on the
//! silhouette, attenuation of the light), `column_profiles` (columns whose edge is not straight
//! within the blur). A new effect on a frame is a step with a file of its own.

pub(crate) mod column_profiles;
pub(crate) mod contamination_layer;
pub(crate) mod exposure;
pub(crate) mod frame_job;
pub(crate) mod request;
#[allow(clippy::module_inception, reason = "the file of the folder's main type")]
pub(crate) mod scene;
pub(crate) mod true_optics;

pub use request::FrameRequest;
pub use scene::Scene;
pub use true_optics::OpticalSetup;
