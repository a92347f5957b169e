//! The job of one frame for the kernel: its parameters and the tables that they index.

use super::column_edges::{Bands, Column};
use super::light_map::LightMap;
use super::params::Params;
use crate::frame::PixelFormat;
use crate::render::optics::esf_table::{EsfTable, Node};

/// The job of a frame.
#[derive(Clone, Debug)]
pub struct Job<'a> {
    /// Uniforms.
    pub params: Params,
    /// Format of the pixels written.
    pub format: PixelFormat,
    /// Edges of every column.
    pub columns: Vec<Column>,
    /// Rows that an edge affects.
    pub bands: Bands,
    /// Transmission of the contamination, pixel by pixel; none where nothing dims the light.
    pub contamination: Option<LightMap>,
    /// The edge-spread table.
    pub esf: &'a EsfTable,
    /// Nodes over a pixel.
    pub quadrature: Vec<Node>,
    /// Whether edges lie between two tables.
    pub stacked: bool,
    /// Light down the columns whose edges are not straight, four rows per element; indexed by the
    /// edges after `esf`.
    pub profiles: Vec<[f32; 4]>,
}
