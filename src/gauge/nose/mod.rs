//! The nose of a back-lit insert: a frame to both cutting edges, sectors, and the support function.
//!
//! A coarse search (`contour`, `corner`) finds the insert's silhouette and its nose: two straight
//! edges that meet outside of it. Then every pixel of a band along both edges and the nose takes
//! part in the ring's maximum-likelihood fit (`bands`, along the `path` found so far): levels, blur
//! and noise pooled, the contour free in every sector. The edges' calipers give two lines with
//! their covariance (`line`), these the centre at the nominal radius from both (`centre`), the
//! nose's sectors its radii, and a penalised smooth of them (`smoother`) the support of the convex
//! hull (`hull`) with its covariance (`support`). `expected` names a picture that is not the
//! tool's; `wear` compares with the same insert new, `axes` finds the machine's axes from moves;
//! `paper` measures by the way of a published paper, for comparison.
//!
//! Places are (column, −row), px: as seen, directions count from the right counter-clockwise.
//!
//! In: a frame and [`NoseSettings`]. Out: [`NoseMeasurement`] (`result`) in px, or a
//! [`NoseImageError`]. One more figure of a nose is a field of `result`, computed in `measurement`.

pub(crate) mod axes;
pub(in crate::gauge) mod bands;
mod cells;
mod centre;
mod contour;
mod corner;
mod error;
mod expected;
mod hidden_corner;
mod hull;
pub(crate) mod limits;
pub(in crate::gauge) mod line;
mod measurement;
pub(crate) mod paper;
mod path;
mod result;
mod settings;
mod smoother;
mod support;
mod wear;

#[cfg(test)]
pub(crate) use error::NoseImageError;
pub(crate) use measurement::measure_nose;
pub(crate) use result::{NoseMeasurement, NoseSector, Reference, SupportValue};
pub(crate) use settings::{ExpectedNose, NoseSettings};
pub(crate) use wear::{BaselineNose, Wear, wear};
