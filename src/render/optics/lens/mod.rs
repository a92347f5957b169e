//! The lens and its light beyond the edge spread: where points land, and how bright the field is.
//!
//! - [`Distortion`]: radial and tangential, forward and inverse;
//! - [`FieldLight`]: vignetting and gradient of the backlight, a factor for every pixel;
//! - [`entocentric`]: outlines seen in perspective, and the envelope over z that tilt makes of a
//!   shoulder.

mod distortion;
pub mod entocentric;
mod field_light;

pub use distortion::Distortion;
pub use field_light::FieldLight;
