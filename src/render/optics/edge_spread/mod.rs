//! Families of the edge-spread function: the transition from light to shadow at a straight edge.
//!
//! Every family ends as an [`EdgeSpread`], a table over the signed distance d into the light in µm
//! on the object, so that a measured one can replace a computed one:
//!
//! - [`GaussianBlur`]: the limit of a sum of many small blurs;
//! - [`MeasuredEdge`]: read from a file;
//! - [`PartiallyCoherentEdge`]: a telecentric camera gauge, circular pupil and circular source,
//!   with defocus;
//! - [`CylinderEdge`]: the same camera before a thick round part, whose limb the light grazes;
//! - [`LaserShadow`]: collimated laser light without a lens;
//! - [`GrazingReflection`]: the reflection of a polished cylinder, in addition to any of them.
//!
//! `field_stack` has the partially coherent edge through a lens with aberrations.
//!
//! All but [`CylinderEdge`] are knife-edge results; for a thick, shiny cylinder each of them is an
//! approximation (see [`GrazingReflection`]). The table holds the light at a point;
//! [`EdgeSpread::over_pixel`] integrates it over a pixel's area.

pub(crate) mod cylinder;
mod field_stack;
mod focus_stack;
pub(crate) mod fresnel_integrals;
pub(crate) mod gaussian;
mod grazing;
mod laser;
mod limb_stack;
mod measured;
mod partial;
pub(crate) mod quadrature;
mod shifts;
mod table;
mod transmission;

pub use self::{
    cylinder::CylinderEdge, grazing::GrazingReflection, laser::LaserShadow, measured::MeasuredEsf,
    partial::PartiallyCoherentEdge,
};
#[cfg(test)]
pub(crate) use field_stack::edge_in_field;
pub(crate) use field_stack::{FieldGrid, FieldStack, check_beside_aberrations};
pub(crate) use focus_stack::FocusStack;
pub(crate) use gaussian::GaussianBlur;
pub(crate) use limb_stack::{LimbLayout, LimbStack};
pub(crate) use measured::MeasuredEdge;
pub(crate) use shifts::Shifts;
pub(crate) use table::EdgeSpread;
