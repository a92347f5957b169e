//! What a sensor does to the means of a frame, as the pass on the host takes it.

use super::params::Params;
use crate::frame::PixelFormat;

/// What a sensor does to the means of a frame.
#[derive(Clone, Debug)]
pub struct Readout {
    /// Parameters of the frame that is read out, with noise and the pixels' pattern.
    pub params: Params,
    /// Its format.
    pub format: PixelFormat,
    /// Its rows.
    pub rows: Vec<RowTerms>,
    /// Column of the drawn means at which it begins.
    pub first_column: usize,
    /// Relative gain that each of its columns adds.
    pub column_gain: Vec<f32>,
    /// Offset that each of its columns adds, counts.
    pub column_offset: Vec<f32>,
    /// Shares of the four neighbours, and the response.
    pub response: Response,
}

/// A row of the frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowTerms {
    /// Its row in the drawn means.
    pub drawn: usize,
    /// Row of the sensor.
    pub sensor: u32,
    /// Relative gain that it adds.
    pub gain: f32,
    /// Offset that it adds, counts: its own of every frame, and the noise of this one.
    pub offset: f32,
}

/// Shares of the neighbours and the response of the readout.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Response {
    /// Share of each neighbour in the row.
    pub along: f32,
    /// Share of each neighbour in the column.
    pub down: f32,
    /// Counts above black at which the well is full.
    pub full_well: f32,
    /// Relative departure a count above black.
    pub quadratic: f32,
    /// Relative departure a squared count above black.
    pub cubic: f32,
}
