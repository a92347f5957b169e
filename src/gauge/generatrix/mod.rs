//! The generatrix of a shaft in a frame: its lines and arcs at any angle, end faces included.
//!
//! The gauge of diameters reads an edge column by column, up to 45°. Lengths, cones and radii need
//! the lines and arcs themselves. What the drawing expects of them is known in a run, so that no
//! search is needed and no slope is taken for a shoulder: every piece of the expected outline
//! (`expected`) is followed by a band, all bands take part in one maximum-likelihood fit of the
//! ring's pixel-integrated edge (`measurement`), and a piece is the line or the circle that its
//! calipers lie on. Calipers that leave it are contamination, chips or the fillet beside it: they
//! are left out by their distance from the piece, whatever its slope, and counted.
//!
//! Valid for blur below 3 px, pieces within 8 px of where they are expected and of five calipers
//! of 8 px or more, arcs of 8 px radius or more. A lens' distortion is not corrected.
//!
//! In: a frame, pieces (X, Z) in mm with the side of the silhouette, and the [`Placement`] of the
//! axis in the image. Out: [`FoundPiece`] each (`found`), in px, and in mm by a scale and an edge
//! offset. One more kind of piece is a variant of [`FoundPiece`] and of the band's `Shape`.

mod arc;
mod band;
mod expected;
mod found;
pub(crate) mod limits;
mod measurement;

pub(crate) use expected::{ExpectedPiece, HalfSilhouette, Placement};
pub(crate) use found::FoundPiece;
pub(crate) use measurement::{GeneratrixError, measure_generatrix};

#[cfg(test)]
mod tests;
