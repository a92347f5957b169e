//! Scene, optics and sensor to frames: silhouettes in f64, pixels on the GPU or its CPU twin.
//!
//! [`OpticalBench::resolve`] draws the true bench, [`Scene::new`] puts a shaft before it, [`Renderer::render`] takes
//! a frame. The twin ([`shadowgraph`]) and the shader of the same name are judged by [`reference`].

mod bench;
pub mod columns;
pub mod contamination;
mod edge_cells;
mod error;
pub mod esf;
pub mod esf_families;
mod exposure;
pub mod form;
pub mod gpu;
mod laser_shoulder;
pub mod lens;
pub mod light_map;
pub mod motion;
pub mod noise;
mod optics;
pub mod params;
mod profiles;
pub mod reference;
mod renderer;
mod scene;
mod sensor_presets;
pub mod settings;
pub mod shadowgraph;
pub mod silhouette;
mod veil;

pub use bench::OpticalBench;
pub use error::RenderError;
pub use renderer::{BackendChoice, Renderer};
pub use scene::{FrameRequest, Scene};
