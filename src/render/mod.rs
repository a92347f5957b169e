//! Scene, optics and sensor to frames: silhouettes in f64, pixels on the GPU or its CPU twin.
//!
//! In: a [`Shaft`](crate::shaft::Shaft), the settings of an optical setup ([`settings`]) and the
//! seed of its departures. Out: frames in counts, with the true rows of both edges.
//! [`OpticalSetup::resolve`] draws the true setup, [`Scene::new`] places a shaft in it,
//! [`frame_job`] computes what the kernel needs of a frame, [`Renderer::render`] renders it.
//!
//! From the body to the pixel: `form` (a body from the `[shaft]` table), `silhouette` (its
//! outline in f64), `optics` (edge spread, lens), `motion`, [`contamination`], `sensor`;
//! `insert` draws back-lit noses of tools; `scene` joins the others into the job of one frame, and
//! `kernel` (the shader and its CPU twin) or `gpu` computes it. The twin (`shadowgraph`) is
//! compared with `reference`, which shares no code with it. A new effect on the light goes into the
//! folder of its cause, has a table in [`settings`], and enters a frame in `scene`; a folder
//! imports only folders that `tests/architecture.rs` lists before it.

pub mod contamination;
mod error;
pub(crate) mod flank;
pub(crate) mod form;
pub(crate) mod gpu;
pub(crate) mod insert;
pub(crate) mod kernel;
pub(crate) mod motion;
pub(crate) mod optics;
mod renderer;
pub(crate) mod scene;
mod sensor;
pub mod settings;
pub(crate) mod silhouette;

pub use self::{
    error::RenderError,
    optics::lens,
    renderer::{BackendChoice, Renderer},
    scene::{FrameRequest, OpticalSetup, Scene, frame_job},
};
#[cfg(test)]
#[cfg(test)]
pub(crate) use kernel::reference;
#[cfg(test)]
#[cfg(test)]
pub(crate) use kernel::shadowgraph;
#[cfg(test)]
pub(crate) use kernel::{column_edges as columns, noise, params};
pub(crate) use optics::edge_spread as esf_families;
#[cfg(test)]
pub(crate) use optics::esf_table as esf;
pub(crate) use scene::geometric_edges;
