//! Tiles of the sensor, bands of them, and requests for a window: the link between layers and maps.

use std::ops::Range;

/// Side of a tile, pixels.
pub(crate) const TILE: usize = 32;

/// A row of tiles: several whole rows of a map, with the requested output.
pub(super) struct Band<'a> {
    /// Its first row in the map.
    pub first: i64,
    pub columns: usize,
    /// Factors, row-major.
    pub values: &'a mut [f32],
    /// Bits of the mask, where requested.
    pub mask: Option<&'a mut [u8]>,
    /// Whether each tile may contain a factor other than 1.
    pub touched: &'a mut [bool],
}

/// A request for the light of a window.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TransmissionRequest {
    /// Rows and columns.
    pub size: [usize; 2],
    /// Whether the mask is requested as well.
    pub with_mask: bool,
    /// Rows of the window whose light is not needed.
    pub unseen: Range<i32>,
}
