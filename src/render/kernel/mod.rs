//! The kernel: pixels of a frame from the edges of its columns, as the shader
//! `shaders/shadowgraph.wgsl` computes them.
//!
//! In: [`job::Job`], borrowed views of [`column_edges::Column`], the edge-spread table, the
//! [`light_map`] and the parameters of one frame. Out: counts, packed in words. [`shadowgraph`]
//! (one pixel) and [`cpu`] (blocks of pixels) are the CPU twin of the shader, function by function
//! with the same names and the same order of operations; `edge_cells` computes the pixels at an
//! edge in lanes; [`noise`] computes the noise of a pixel from a counter hash.
//! [`reference`](mod@reference) computes the light of a pixel in f64 by quadrature and shares
//! nothing with the others, which are tested against it.
//!
//! A new term of the light enters the shader and [`shadowgraph`] under one name, its parameters
//! [`params::Params`], and its exact form [`reference`](mod@reference);
//! `tests/inside/render_shaders.rs` compares layouts and names.

pub mod column_edges;
pub mod cpu;
pub(crate) mod edge_cells;
pub mod job;
pub mod light_map;
pub mod noise;
pub mod params;
pub mod reference;
pub mod shadowgraph;
