//! The model of an edge: the edge-spread function, its integral over a pixel, and its systematic
//! residual.
//!
//! In: a distance from the edge, a blur. Out: light as a share of the bright field, with
//! derivatives by place and blur (`gaussian::EdgeSample`); `edge_spread::EdgeSpreadFunction` is the
//! one type that all fits take, whatever the function is. Distances are in px, positive into the
//! light.
//!
//! One more edge-spread function is one more variant of `EdgeSpreadFunction` with its border
//! values; everything that is fitted takes it from there. No file here sees a frame.

pub(crate) mod edge_spread;
pub(crate) mod edge_table;
pub(crate) mod gaussian;
pub(crate) mod shape_terms;
pub(crate) mod systematic_residual;
