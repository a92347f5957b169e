//! How long the window around an edge is: the edge itself as far as its blur reaches, and flat
//! pixels either side.

use crate::gauge::edge::model::edge_spread::EdgeSpreadFunction;

/// Phases reach this far from the window's central pixel, px; beyond, the window is moved.
pub(crate) const PHASE_REACH: f32 = 0.75;
/// Pixels of the longest window, and of the longest one over the rings of coherent light without a
/// lens.
pub(crate) const MOST_WIDTH: (usize, usize) = (72, 256);
/// Flat pixels either side beyond the reach of an edge; over rings the mean of more of them takes
/// the farthest ripple out of the level.
const FLAT: (f64, f64) = (5.0, 24.0);
/// Width below which both edges are fitted together, px: above it their windows are clear of each
/// other up to a blur of 2 px.
pub(crate) const WIDEST_PX: f64 = 24.0;

/// Index of a window's central pixel.
pub(crate) fn half(width: usize) -> usize {
    width / 2 - 1
}

/// Width of the window for a blur: the edge itself and five flat pixels or more either side.
pub(crate) fn window_width(shape: &EdgeSpreadFunction, sigma: f64) -> usize {
    let (flat, most) = if shape.is_ringed() { (FLAT.1, MOST_WIDTH.1) } else { (FLAT.0, MOST_WIDTH.0) };
    let half = (shape.reach(sigma) + flat + f64::from(PHASE_REACH)).ceil() as usize;
    (2 * half + 2).next_multiple_of(8).clamp(24, most)
}

/// Pixels either side of the central one in the part of the window that carries the weights, to a
/// multiple of 8 in all.
pub(crate) fn core_width(shape: &EdgeSpreadFunction, sigma: f64) -> usize {
    let half = (shape.reach(sigma) + f64::from(PHASE_REACH)).ceil() as usize;
    (2 * half + 2).next_multiple_of(8)
}
