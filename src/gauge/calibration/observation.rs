//! From the edges of a master's frame to a few observations: mean edges of blocks of columns.

use super::super::edges::FrameEdges;
use super::imaging_model::{ColumnSpread, LensModel};
use crate::gauge::limit::limits;
use crate::gauge::width::axis_pose::Pose;
use crate::gauge::width::column_means::ColumnMeans;

limits! {
    /// Observations of a frame.
    ObservationLimits = "observation";
    /// Blocks a frame is parted into: enough to see distortion along the shaft, which is a
    /// parabola, few enough that each is quiet.
    blocks: usize = 6;
}

/// Mean edges of a block of columns of one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Observation {
    /// Index of the master.
    pub master: usize,
    /// Index of the frame over all masters: its columns share an error.
    pub frame: usize,
    /// Middle of the block, columns from the frame's centre.
    pub column_px: f64,
    /// Variance of its columns, px².
    pub column_variance_px2: f64,
    /// Mean upper edge, rows from the frame's centre.
    pub top_px: f64,
    /// Mean lower edge, rows from the frame's centre.
    pub bottom_px: f64,
    /// Chord factor χ of the axis' tilt.
    pub chord: f64,
    /// Distance of the axis from the plane of the masters, mm.
    pub axis_y_mm: f64,
    /// Standard uncertainty of the width that the block has for itself, px.
    pub u_width_px: f64,
    /// Standard uncertainty of the width that all blocks of the frame share (levels, edge model),
    /// px.
    pub u_shared_px: f64,
    /// The part of it due to the edge model, px: the same in all frames of one focus.
    pub u_misfit_px: f64,
}

impl Observation {
    /// Its columns from the frame's centre.
    pub(crate) fn along(&self) -> ColumnSpread {
        ColumnSpread { mean_px: self.column_px, variance_px2: self.column_variance_px2 }
    }
}

/// Observations of one frame of a master; empty where no block shows both edges.
pub(crate) fn observe(
    edges: &FrameEdges,
    lens: &LensModel,
    master: usize,
    frame: usize,
    axis_y_mm: f64,
) -> Vec<Observation> {
    let limits = ObservationLimits::get();
    let columns = edges.columns();
    let chord = Pose::of(edges).chord_factor();
    (0..limits.blocks)
        .filter_map(|block| {
            let range = block * columns / limits.blocks..(block + 1) * columns / limits.blocks;
            let means = ColumnMeans::over(edges, range)?;
            Some(Observation {
                master,
                frame,
                column_px: means.column_px - lens.centre_column_px,
                column_variance_px2: means.column_variance_px2,
                top_px: means.rows_px.0 - lens.centre_row_px,
                bottom_px: means.rows_px.1 - lens.centre_row_px,
                chord,
                axis_y_mm,
                u_width_px: means.own_variance_px2.sqrt(),
                u_shared_px: means.u_shared_px,
                u_misfit_px: means.u_misfit_px,
            })
        })
        .collect()
}
