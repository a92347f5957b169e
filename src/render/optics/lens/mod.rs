//! The lens and its light beyond the edge spread: positions of image points, and brightness of the
//! field.
//!
//! - `Distortion`: radial and tangential, forward and inverse;
//! - [`FieldLight`]: vignetting and gradient of the backlight, a factor for every pixel;
//! - `aberrations`: spherical aberration, coma and astigmatism by the height in the field;
//! - `FieldCurvature`: where the lens is in focus over the field;
//! - `entocentric`: outlines in perspective, and the envelope over z of a tilted shoulder.

pub(crate) mod aberrations;
mod distortion;
pub(crate) mod entocentric;
mod field_curvature;
mod field_light;

pub use self::aberrations::FieldAberrations;
pub use self::{distortion::Distortion, field_curvature::FieldCurvature, field_light::FieldLight};
