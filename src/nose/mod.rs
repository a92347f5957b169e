//! The nose of a turning tool in its reference plane P_r (ISO 3002-1), as measured, and the angles
//! and the imaginary tip by which a control takes it.
//!
//! Vectors and angles as in `outline`. In: support values of the nose with their covariance.
//! Out: [`NoseProfile`], where and how far the nose reaches in a direction; [`ToolGeometry`], which
//! normals of a surface the tool can cut.

mod geometry;
mod profile;
mod tip;

pub(crate) use geometry::{Feed, ToolGeometry};
pub(crate) use profile::{NoseError, NoseProfile, Support};
pub(crate) use tip::{Numbering, TipDirection};
