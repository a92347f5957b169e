//! Scene, optics and sensor to frames: silhouettes in f64, pixels on the GPU or its CPU twin.

pub mod contamination;
mod error;
pub mod esf_families;
pub mod lens;
pub mod motion;
pub mod settings;

pub use error::RenderError;
