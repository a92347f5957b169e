//! One frame made ready for the kernel: its parameters and the tables they index.

use super::column_edges::{Bands, Column};
use super::light_map::LightMap;
use super::params::Params;
use crate::frame::PixelFormat;
use crate::render::optics::esf_table::{EsfTable, Node};

/// A frame made ready for the kernel.
#[derive(Clone, Debug)]
pub struct Job<'a> {
    /// Uniforms.
    pub params: Params,
    /// Format of the pixels written.
    pub format: PixelFormat,
    /// Edges of every column.
    pub columns: Vec<Column>,
    /// Rows that an edge touches.
    pub bands: Bands,
    /// What contamination leaves of the light, pixel by pixel; none where nothing dims it.
    pub contamination: Option<LightMap>,
    /// The edge-spread table.
    pub esf: &'a EsfTable,
    /// Nodes over a pixel.
    pub quadrature: Vec<Node>,
    /// Whether edges lie between two tables.
    pub stacked: bool,
    /// Light down the columns whose edges are no straight lines, four rows an element; edges index
    /// it behind `esf`.
    pub profiles: Vec<[f32; 4]>,
}
