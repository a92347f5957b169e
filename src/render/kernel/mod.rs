//! The kernel: pixels of a frame from the edges of its columns, as the shader
//! `shaders/shadowgraph.wgsl` computes them.
//!
//! In: [`job::Job`], borrowed views of [`column_edges::Column`], the edge-spread table, the
//! [`light_map`] and the parameters of one frame. Out: counts, packed in words. [`shadowgraph`]
//! (one pixel) and [`cpu`] (blocks of pixels) are the CPU twin of the shader, function by function
//! with the same names and the same order of operations; `edge_cells` computes the pixels at an
//! edge in lanes; [`noise`] computes the noise of a pixel from a counter hash; [`readout`] turns
//! noise-free frames into those of a sensor that is more than its pixels, on the host.
//! `reference` computes the light of a pixel in f64 by quadrature and shares
//! nothing with the others, which are tested against it.
//!
//! A new term of the light enters the shader and [`shadowgraph`] under one name, its parameters
//! [`params::Params`], and its exact form `reference`;
//! `tests/inside/render_shaders.rs` compares layouts and names.

pub(crate) mod column_edges;
pub(crate) mod cpu;
pub(crate) mod edge_cells;
pub(crate) mod job;
pub(crate) mod light_map;
pub(crate) mod noise;
pub(crate) mod params;
pub(crate) mod readout;
pub(crate) mod readout_terms;
#[cfg(test)]
pub(crate) mod reference;
pub(crate) mod shadowgraph;
