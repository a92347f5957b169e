//! Scene: a shaft in front of a camera, and a frame of it as the mean over the instants of its
//! exposure.
//!
//! In: a shaft, an [`OpticalSetup`] (the true optical setup, drawn once from settings and seed) and
//! a [`FrameRequest`] (spindle angle, axial field, seed of the noise). Out: the true rows of both
//! edges of every column ([`geometric_edges`]), and the [`Job`](super::kernel::job::Job) that the
//! kernel computes ([`fn@frame_job`]).
//!
//! One way, each a value from those before it: settings → [`OpticalSetup`] (`true_optics`; also
//! what a request reads of the sensor) → [`Scene`] (where the edges of a placed shaft are) →
//! `exposure` (the edges at the instants of an exposure, raised by films; `rolling_shutter`: at the
//! times of their own rows) → `frame_job`, with
//! `contamination_layer` (films on the silhouette, attenuation of the light) and `column_profiles`
//! (columns whose edge is not straight within the blur), and with `sensor_readout` where the sensor
//! is more than the noise of its pixels. A new effect on a frame is a step with a
//! file of its own.

pub(crate) mod column_profiles;
pub(crate) mod contamination_layer;
pub(crate) mod exposure;
pub(crate) mod frame_job;
pub(crate) mod request;
mod rolling_shutter;
#[allow(clippy::module_inception, reason = "the file of the folder's main type")]
pub(crate) mod scene;
mod sensor_readout;
pub(crate) mod true_optics;

pub use self::{frame_job::frame_job, request::FrameRequest, scene::Scene, true_optics::OpticalSetup};
pub(crate) use exposure::geometric_edges;
