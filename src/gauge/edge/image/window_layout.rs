//! How long the window around an edge is: the edge itself as far as its blur reaches, and flat
//! pixels either side.

use crate::gauge::edge::model::edge_spread::EdgeSpreadFunction;
use crate::gauge::limit::limits;

limits! {
    /// How long windows are.
    LayoutLimits = "window_layout";
    /// Pixels of the shortest window, and rows that a frame must have: the blur of 0.2 px needs 2
    /// px either side, five flat ones and the phases' reach, 18 in all, and a multiple of eight
    /// fills the lanes.
    least_width: usize = 24;
    /// Pixels of the longest window but over rings: a multiple of eight. Wider blurs have fewer
    /// flat pixels.
    most_width: usize = 72;
    /// Flat pixels either side beyond the reach of an edge: the mean of five has 0.45 of a pixel's
    /// noise, and levels are pooled over the columns.
    flat_px: f64 = 5.0;
    /// Flat pixels either side over rings: the mean of more of them takes the farthest ripple out
    /// of the level.
    flat_ringed_px: f64 = 24.0;
}

/// Phases reach this far from the window's central pixel, px; beyond, the window is moved. More
/// than half a pixel and what a window is centred within; read in the scoring's lanes.
pub(crate) const PHASE_REACH: f32 = 0.75;
/// Pixels of the longest window, which is one over the rings of coherent light without a lens: the
/// length of an array.
pub(crate) const MOST_WIDTH: usize = 256;
/// Width below which both edges are fitted together, px: above it their windows are clear of each
/// other up to a blur of 2 px. The length of an array.
pub(crate) const WIDEST_PX: f64 = 24.0;

/// Index of a window's central pixel.
pub(crate) fn half(width: usize) -> usize {
    width / 2 - 1
}

/// Width of the window for a blur: the edge itself and five flat pixels or more either side.
pub(crate) fn window_width(shape: &EdgeSpreadFunction, sigma: f64) -> usize {
    let limits = LayoutLimits::get();
    let (flat, most) = if shape.is_ringed() {
        (limits.flat_ringed_px, MOST_WIDTH)
    } else {
        (limits.flat_px, limits.most_width)
    };
    let half = (shape.reach(sigma) + flat + f64::from(PHASE_REACH)).ceil() as usize;
    (2 * half + 2).next_multiple_of(8).clamp(limits.least_width, most)
}

/// Pixels either side of the central one in the part of the window that carries the weights, to a
/// multiple of 8 in all.
pub(crate) fn core_width(shape: &EdgeSpreadFunction, sigma: f64) -> usize {
    let half = (shape.reach(sigma) + f64::from(PHASE_REACH)).ceil() as usize;
    (2 * half + 2).next_multiple_of(8)
}
