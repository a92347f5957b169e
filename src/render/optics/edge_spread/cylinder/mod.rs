//! Limb of a cylinder: the image of a thick, smooth, opaque round part through a telecentric lens.
//!
//! The light grazes the surface for ±R/M, M = (kR/2)^(1/3) (Ø18 mm at 525 nm: M = 38, ±.24 mm), and
//! its half shadow moves the image edge .5-1.8 µm into the light against a thin screen in the plane
//! of the axis, at apertures up to .02. Lens, source and further blur are those of
//! [`PartiallyCoherentEdge`](super::PartiallyCoherentEdge); what is added is the radius, the
//! surface, and the sign of the focus: light that has grazed the limb diverges from it.
//!
//! In: [`CylinderEdge`] (the `[optics.esf.cylinder]` table), the radius of curvature of the section
//! at its limb (half the local diameter; texture along the axis follows the mean line) and the
//! distance of the axis. Out: an [`EdgeSpread`](super::EdgeSpread). `surface` has the impedance of
//! materials, films and textures, `half_shadow` Fock's integral P(s) on top of `airy`, `image` the
//! sum over pupil and source.
//!
//! Scalar for each polarisation, paraxial, M ≥ 11. Over ±60 µm it agrees with the series of the
//! infinite cylinder (Ø2 to Ø18, NA .02 and .06) to 1.2e-4 of full light below S = 1 and 4e-4 above
//! (`tests/inside/optics_cylinder.rs`). The mirrored light of
//! [`GrazingReflection`](super::GrazingReflection), its limit for M·NA → ∞, is part of it: both
//! together are refused.

pub(crate) mod airy;
mod edge;
pub(crate) mod half_shadow;
pub(crate) mod image;
mod material;
pub(crate) mod surface;

pub use self::edge::CylinderEdge;
#[cfg(test)]
pub(crate) use self::edge::Polarisation;
pub(crate) use self::material::Material;
