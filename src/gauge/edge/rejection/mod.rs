//! Which fitted edges are not edges of the part: residuals, neighbours, and contamination on one
//! side.
//!
//! In: lines of fitted [`Edge`](crate::gauge::Edge)s. Out: the same lines, in which refused edges
//! are gaps with a reason, and u includes the model uncertainty where neighbours share a residual.
//! Px throughout.
//!
//! `residual_test`: whether noise explains the residual of an edge. `neighbour_test`: whether an
//! edge lies on the line of its neighbours. `one_sided`: whether both sides of a stretch move
//! alike, as those of a part do, by `departures` from the `centreline` unless the part is `bent`,
//! then by `local_bumps`, each extended to its base (`bump_extent`).
//!
//! One more test is one more file: a function over lines, called once in `side` (one line) or in
//! `stream` (both), with its thresholds and their reasons at its head.

pub(crate) mod bent;
pub(crate) mod bump_extent;
pub(crate) mod centreline;
pub(crate) mod departures;
pub(crate) mod local_bumps;
pub(crate) mod neighbour_test;
pub(crate) mod one_sided;
pub(crate) mod residual_test;
