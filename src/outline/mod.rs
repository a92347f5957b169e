//! Outlines in the plane of the spindle's axis: chains of lines and arcs.
//!
//! Vectors are (X, Z), mm: X the distance from the axis, not the diameter, Z along the spindle from
//! the chuck face. An angle a turns from X to Z: the normal n(a) = (cos a, sin a) is 0° on a
//! cylinder, 90° on an end face towards the tailstock, the half angle on a cone that grows towards
//! the chuck, negative where the outline falls towards the chuck, 180° in a bore.
//!
//! An outline runs with the material on one side: its direction is t(a) = (−sin a, cos a), so that
//! n points out of the material. A shaft's runs to the tailstock, a bore's to the chuck; along a
//! convex arc a rises, along a concave one it falls.
//!
//! In: corners as on a drawing. Out: [`Outline`] of [`Piece`]s. `piece` is one line or arc,
//! `meeting` where two of them intersect, `corners` makes outlines.

mod corners;
mod meeting;
mod piece;

pub(crate) use corners::{Outline, Side};
pub(crate) use meeting::meetings;
pub(crate) use piece::{Arc, Piece, unwrapped};
