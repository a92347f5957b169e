//! What the kernel is told about a frame: the same bytes for the shader and for its CPU twin.

use super::noise::row_key;
use super::shadowgraph::shaped;
use super::{columns::Bands, columns::Column, esf::EsfTable, esf::Node};
use crate::frame::PixelFormat;

/// Uniforms of `shaders/shadowgraph.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Params {
    /// Rows of the frame.
    pub rows: u32,
    /// Columns of the frame.
    pub columns: u32,
    /// 32-bit words a row.
    pub words: u32,
    /// Nodes of the quadrature over a pixel.
    pub nodes: u32,
    /// Sensor row of the frame's row 0.
    pub row0: u32,
    /// Sensor column of the frame's column 0.
    pub column0: u32,
    /// Rows of a band.
    pub band_rows: u32,
    /// Segments of the edge-spread table.
    pub esf_segments: u32,
    /// Reach of the edge-spread table in its own units.
    pub esf_reach: f32,
    /// Segments of the edge-spread table a unit.
    pub esf_per_unit: f32,
    /// Grey value of the shadow, counts.
    pub shadow: f32,
    /// Bright field less shadow, counts.
    pub contrast: f32,
    /// Grey value without electrons, counts.
    pub black: f32,
    /// Electrons a count.
    pub electrons_per_count: f32,
    /// Variance of the read noise, electrons².
    pub read_variance: f32,
    /// 1 with noise, 0 without.
    pub noise: f32,
    /// Noise polynomial of the bright field.
    pub flat_bright: [f32; 4],
    /// Noise polynomial of the shadow.
    pub flat_shadow: [f32; 4],
    /// Largest count.
    pub full_scale: f32,
    /// 1 where a pixel may see both edges.
    pub overlap: u32,
    /// Fills up 16 bytes.
    pub padding: [f32; 2],
}

/// Levels and noise of a sensor, in counts of one format.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels {
    /// Grey value of the shadow, counts.
    pub shadow: f64,
    /// Grey value of the bright field, counts.
    pub bright: f64,
    /// Grey value without electrons, counts.
    pub black: f64,
    /// Electrons a count.
    pub electrons_per_count: f64,
    /// Temporal dark noise, electrons.
    pub read_noise_e: f64,
}

impl Levels {
    /// The same light and sensor read out with another number of bits.
    #[must_use]
    pub fn in_format(self, from: PixelFormat, to: PixelFormat) -> Self {
        let (Some(from), Some(to)) = (from.full_scale(), to.full_scale()) else { return self };
        let ratio = (f64::from(to) + 1.0) / (f64::from(from) + 1.0);
        Self {
            shadow: self.shadow * ratio,
            bright: self.bright * ratio,
            black: self.black * ratio,
            electrons_per_count: self.electrons_per_count / ratio,
            read_noise_e: self.read_noise_e,
        }
    }
}

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
    /// Noise keys of every row.
    pub row_keys: Vec<[u32; 2]>,
    /// The edge-spread table.
    pub esf: &'a EsfTable,
    /// Nodes over a pixel.
    pub quadrature: Vec<Node>,
}

/// Pixels in a 32-bit word of a format.
pub fn pixels_per_word(format: PixelFormat) -> u32 {
    match format {
        PixelFormat::Mono8 => 4,
        PixelFormat::Mono10 | PixelFormat::Mono12 | PixelFormat::Mono16 => 2,
        PixelFormat::F32 => 1,
    }
}

/// Window of the sensor that a frame shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// First sensor row.
    pub row: u32,
    /// First sensor column.
    pub column: u32,
    /// Rows.
    pub rows: u32,
    /// Columns.
    pub columns: u32,
}

impl Params {
    /// Uniforms of a frame; bands and quadrature are filled in from their tables.
    pub fn new(window: Window, format: PixelFormat, levels: &Levels, noise: bool) -> Self {
        let mut params = Self {
            rows: window.rows,
            columns: window.columns,
            words: window.columns.div_ceil(pixels_per_word(format)),
            nodes: 0,
            row0: window.row,
            column0: window.column,
            band_rows: 0,
            esf_segments: 0,
            esf_reach: 0.0,
            esf_per_unit: 0.0,
            shadow: levels.shadow as f32,
            contrast: (levels.bright - levels.shadow) as f32,
            black: levels.black as f32,
            electrons_per_count: levels.electrons_per_count as f32,
            read_variance: (levels.read_noise_e * levels.read_noise_e) as f32,
            noise: f32::from(u8::from(noise)),
            flat_bright: [0.0; 4],
            flat_shadow: [0.0; 4],
            full_scale: format.full_scale().map_or(f32::MAX, f32::from),
            overlap: 0,
            padding: [0.0; 2],
        };
        params.flat_bright = shaped(&params, params.shadow + params.contrast);
        params.flat_shadow = shaped(&params, params.shadow);
        params
    }
}

/// Noise keys of a window's rows.
pub fn row_keys(window: Window, seed: u64, frame_id: u64) -> Vec<[u32; 2]> {
    (0..window.rows).map(|r| row_key(seed, frame_id, window.row + r)).collect()
}
