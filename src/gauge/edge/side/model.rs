//! The edge model of one side of a frame: the edge-spread function and its width along the side.

use super::scan::ScanWindows;
use crate::gauge::edge::estimation::blur::{self, BlurEstimate};
use crate::gauge::edge::image::window_layout::window_width;
use crate::gauge::edge::model::edge_spread::EdgeSpreadFunction;

/// An edge-spread function and its blur.
#[derive(Clone, Debug)]
pub(crate) struct EdgeModel {
    pub(crate) shape: EdgeSpreadFunction,
    pub(crate) blur: BlurEstimate,
}

impl EdgeModel {
    /// One blur, px, for the whole side.
    pub(crate) fn uniform(shape: &EdgeSpreadFunction, sigma: f64) -> Self {
        Self { shape: shape.clone(), blur: BlurEstimate::uniform(sigma) }
    }

    /// Width of the windows for a blur.
    pub(crate) fn window_width(&self, sigma: f64) -> usize {
        window_width(&self.shape, sigma)
    }

    /// How far the geometric edge may lie from where a learnt edge-spread function puts it, px.
    pub(crate) fn position_ambiguity(&self) -> f64 {
        self.shape.position_ambiguity(self.blur.mean())
    }

    /// Blur of a column at its slope, px.
    pub(crate) fn sigma_at(&self, scan: &ScanWindows, column: usize) -> f64 {
        let block = BlurEstimate::block(column, scan.windows.centre.len());
        blur::at_slope(self.blur.sigma[block], scan.slope[column])
    }
}
