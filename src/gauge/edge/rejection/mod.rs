//! Which fitted edges are none of the part's: residuals, neighbours, and what adheres to one side.
//!
//! In: lines of fitted [`Edge`](crate::gauge::Edge)s. Out: the same lines, in which refused edges are gaps with a reason, and wider u
//! where a misfit is shared by neighbours. Px throughout.
//!
//! `residual_test` asks of each edge whether noise explains its residual, `neighbour_test` whether it lies where its neighbours do.
//! `one_sided` asks of each stretch whether both sides move as a part's do: `departures` from the `centreline`, unless the part is
//! `bent`, then `local_bumps`, each to its foot (`bump_extent`).
//!
//! One more test is one more file: a function over lines, called once in `side` (one line) or in `stream` (both), with its thresholds
//! and their reasons at its head.

pub(crate) mod bent;
pub(crate) mod bump_extent;
pub(crate) mod centreline;
pub(crate) mod departures;
pub(crate) mod local_bumps;
pub(crate) mod neighbour_test;
pub(crate) mod one_sided;
pub(crate) mod residual_test;
