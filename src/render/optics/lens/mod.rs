//! The lens and its light beyond the edge spread: positions of image points, and brightness of the
//! field.
//!
//! - `Distortion`: radial and tangential, forward and inverse;
//! - [`FieldLight`]: vignetting and gradient of the backlight, a factor for every pixel;
//! - `FieldCurvature`: where the lens is in focus over the field;
//! - `entocentric`: outlines in perspective, and the envelope over z of a tilted shoulder.

mod distortion;
pub(crate) mod entocentric;
mod field_curvature;
mod field_light;

pub use self::{distortion::Distortion, field_curvature::FieldCurvature, field_light::FieldLight};
