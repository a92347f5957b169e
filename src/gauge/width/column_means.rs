//! Means over some columns of one frame: the observations of a calibration and the input of a
//! budget.

use super::axis_pose::Pose;
use crate::gauge::edge::acceptance::AcceptanceLimits;
use crate::gauge::edges::{Edge, FrameEdges};

/// Means over the columns of a stretch that have both edges.
pub(crate) struct ColumnMeans {
    /// The columns used.
    pub(crate) used: Vec<usize>,
    /// Their mean, px.
    pub(crate) column_px: f64,
    /// Their variance, px².
    pub(crate) column_variance_px2: f64,
    /// Mean rows of the upper and the lower edge, px.
    pub(crate) rows_px: (f64, f64),
    /// Variance of the mean width by the columns' independent parts, px².
    pub(crate) own_variance_px2: f64,
    /// Standard uncertainty of the width that the columns share (levels, edge model), px.
    pub(crate) u_shared_px: f64,
    /// The part of it due to the edge model, px.
    pub(crate) u_misfit_px: f64,
}

impl ColumnMeans {
    /// Means over `columns`; `None` where fewer than `acceptance.least_valid` have both edges.
    pub(crate) fn over(edges: &FrameEdges, columns: std::ops::Range<usize>) -> Option<Self> {
        let acceptance_limits = AcceptanceLimits::get();
        let used: Vec<usize> = columns.filter(|c| edges.width_px(*c).is_some()).collect();
        if used.len() < acceptance_limits.least_valid {
            return None;
        }
        let n = used.len() as f64;
        let mean = |f: &dyn Fn(usize) -> f64| used.iter().map(|c| f(*c)).sum::<f64>() / n;
        let both = |u: fn(&Edge) -> f32| {
            let square = |e: &Edge| f64::from(u(e)).powi(2);
            mean(&|c| square(&edges.top[c]) + square(&edges.bottom[c]))
        };
        let (own, shared) = (both(|e| e.u_own_px), both(|e| e.u_shared_px));
        let column_px = mean(&|c| c as f64);
        let column_variance_px2 = mean(&|c| (c as f64 - column_px).powi(2));
        let rows_px = (mean(&|c| edges.top[c].row_px), mean(&|c| edges.bottom[c].row_px));
        Some(Self {
            column_px,
            column_variance_px2,
            rows_px,
            own_variance_px2: own / n,
            u_shared_px: shared.sqrt(),
            u_misfit_px: mean(&|c| edges.model_variance(c)).sqrt(),
            used,
        })
    }
}

/// Mean width across the axis over a frame and its standard uncertainty, px; `None` without a
/// usable column.
pub(crate) fn mean_width(edges: &FrameEdges) -> Option<(f64, f64)> {
    let factor = Pose::of(edges).chord_factor();
    let both: Vec<usize> = (0..edges.columns()).filter(|c| edges.width_px(*c).is_some()).collect();
    if both.is_empty() {
        return None;
    }
    let n = both.len() as f64;
    let width = both.iter().filter_map(|c| edges.width_px(*c)).sum::<f64>() / n;
    let u = |line: &[Edge], side: usize| {
        FrameEdges::mean(line, edges.shared_length[side], 0..line.len()).map_or(f64::NAN, |m| m.u_px)
    };
    Some((width * factor, factor * u(&edges.top, 0).hypot(u(&edges.bottom, 1))))
}
