//! Tiles of the sensor, the bands they make, and what is asked for of a window: the way between
//! layers and maps.

use std::ops::Range;

/// Side of a tile, pixels.
pub const TILE: usize = 32;

/// A row of tiles: some whole rows of a map, with what is asked for of it.
pub(super) struct Band<'a> {
    /// Its first row in the map.
    pub first: i64,
    pub columns: usize,
    /// Factors, row-major.
    pub values: &'a mut [f32],
    /// Bits of what touches a pixel, where they are asked for.
    pub mask: Option<&'a mut [u8]>,
    /// Whether each tile may hold a factor other than 1.
    pub touched: &'a mut [bool],
}

/// A request for the light of a window.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TransmissionRequest {
    /// Rows and columns.
    pub size: [usize; 2],
    /// Whether the mask is requested, too.
    pub with_mask: bool,
    /// Rows of the window whose light is not needed.
    pub unseen: Range<i32>,
}
