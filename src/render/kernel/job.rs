//! The job of one frame for the kernel: its parameters and the tables that they index.

use super::column_edges::{Bands, Column};
use super::light_map::LightMap;
use super::params::Params;
use super::readout_terms::Readout;
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
    /// What the sensor does to the frame on the host, where it is more than noise and pattern of
    /// single pixels; the kernel then draws means in f32.
    pub readout: Option<Readout>,
}

impl Job<'_> {
    /// Format, rows and columns of the frame that leaves the renderer.
    pub fn output(&self) -> (PixelFormat, usize, usize) {
        let (params, format) = match &self.readout {
            Some(readout) => (&readout.params, readout.format),
            None => (&self.params, self.format),
        };
        (format, params.size.rows as usize, params.size.columns as usize)
    }
}
