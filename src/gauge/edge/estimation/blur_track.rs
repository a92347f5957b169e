//! The blur of a frame that a stream follows: a shaft that sags towards the camera, or turns out of
//! the centre, is out of focus otherwise in every frame.
//!
//! Noise that grows with the light gives the shadow's base more weight, so that a blur off by δ
//! moves an edge by −δ·I_xσ/I_xx: both edges outwards or both inwards. The score for σ at the edges
//! just placed, summed over blocks along the shaft, gives the change of a parabola σ(t) since the
//! frame before, and the edges just placed are moved by it to first order, or placed anew. Nothing
//! is averaged over frames: an average lags behind a shaft that is fed along or turns, at the same
//! places in every turn, and a level edge, whose phase does not travel, keeps what the lag costs.
//! Frames by themselves and frames followed owe their blur to the same columns and agree.

use nalgebra::{Matrix3, Vector3};

use super::blur::{BLOCKS, BlurEstimate, BlurLimits, BlurSums, middle, sample};
use super::column_fit::ColumnJob;
use super::scoring::dot_above;
use super::scoring_table::Table;
use crate::gauge::edge::image::scan_windows::Windows;
use crate::gauge::edge::image::window_layout::PHASE_REACH;
use crate::gauge::edges::Edge;
use crate::gauge::limit::limits;

limits! {
    /// How far a stream follows the blur of its frames.
    BlurTrackLimits = "blur_track";
    /// Standard deviation of trend and bend of the blur along the field, as a share of the blur,
    /// that are possible from one frame to the next without showing: a third of what is likely of a
    /// frame by itself ([`BlurLimits::likely_course`]). Tuned: see study limits.
    likely_trend: f64 = 0.01;
    /// The same where columns are readings one after the other, and share their blur: none.
    level_trend: f64 = 1e-9;
    /// Largest change of the blur, as a share of it, by which edges are moved to first order; what
    /// that leaves is its square, below 1e-4 px.
    first_order: f64 = 0.01;
    /// The same among rings, the phase of whose farthest one it turns by a sixth of a radian.
    first_order_of_rings: f64 = 1e-3;
    /// Times that edges are placed anew for a change of the blur; a change of a tenth leaves a
    /// hundredth after the first and a ten-thousandth after the second.
    most_refits: usize = 2;
    /// Change of the blur, as a share of it, beyond which the frame is searched anew. Tuned: see
    /// study limits.
    lost: f64 = 0.15;
}

/// What a followed frame does to a side's blur.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Change {
    /// Nothing shows it.
    None,
    /// The edges were moved by it.
    Moved,
    /// The edges are to be placed anew.
    Refit,
    /// More than a stream follows.
    Lost,
}

/// What the edges of a followed frame, once fitted, show of its blur.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlurTrack {
    /// Whether the frame's blur is to be followed.
    follows: bool,
    /// Sums over the blur of the tables that the edges were fitted by.
    sums: [BlurSums; BLOCKS],
}

/// A side's edges just placed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed<'a> {
    pub(crate) line: &'a [Edge],
    /// Their slope, px per column.
    pub(crate) slope: &'a [f32],
}

fn basis(block: usize) -> Vector3<f64> {
    let t = middle(block);
    Vector3::new(1.0, t, t * t - 1.0 / 12.0)
}

impl BlurTrack {
    /// Begins a fit; `follows`: the frame is followed, and its blur is not given.
    pub(crate) fn begin(follows: bool) -> Self {
        Self { follows, sums: [BlurSums::default(); BLOCKS] }
    }

    /// Adds the edges of columns that share a table.
    pub(crate) fn add(
        &mut self,
        job: &ColumnJob<'_>,
        columns: std::ops::Range<usize>,
        Placed { line, slope }: Placed<'_>,
    ) {
        if !self.follows || columns.is_empty() {
            return;
        }
        let BlurLimits { final_per_block, steepest, .. } = *BlurLimits::get();
        let count = job.windows.centre.len();
        let blocks = BlurEstimate::block(columns.start, count)..=BlurEstimate::block(columns.end - 1, count);
        for block in blocks {
            let sum = &mut self.sums[block];
            for column in sample(block, count, final_per_block).filter(|c| columns.contains(c)) {
                let edge = &line[column];
                if edge.is_usable() && slope[column].abs() <= steepest as f32 {
                    add_column(sum, job, column, edge);
                }
            }
        }
    }

    /// What the frame just fitted shows of the blur: moves its edges by it, and keeps it for the
    /// next frame to begin with.
    pub(crate) fn follow(
        &self,
        blur: &mut BlurEstimate,
        relative_variance: f64,
        view: &TrackView<'_>,
        line: &mut [Edge],
    ) -> Change {
        let limits = BlurTrackLimits::get();
        let (mut normal, mut score) = (Matrix3::zeros(), Vector3::zeros());
        for (block, sum) in self.sums.iter().enumerate().filter(|(_, s)| s.information > 0.0) {
            let (phi, information) = (basis(block), sum.information / relative_variance);
            normal += phi * phi.transpose() * information;
            score += phi * (sum.score / relative_variance);
        }
        if !(normal[(0, 0)] > 0.0 && normal[(0, 0)].is_finite()) {
            return Change::None;
        }
        let sigma = blur.mean();
        let likely = if view.level_lines { limits.level_trend } else { limits.likely_trend };
        let trend = (likely * sigma).powi(-2);
        let likely = Matrix3::from_diagonal(&Vector3::new(0.0, trend, trend));
        let Some(change) = (normal + likely).try_inverse().map(|inverse| inverse * score) else {
            return Change::None;
        };
        let mut delta = [0.0; BLOCKS];
        for (block, value) in delta.iter_mut().enumerate() {
            *value = basis(block).dot(&change);
        }
        let largest = delta.iter().fold(0.0_f64, |most, d| most.max(d.abs()));
        if !(largest < limits.lost * sigma) {
            return Change::Lost;
        }
        blur.sigma.iter_mut().zip(&delta).for_each(|(s, d)| *s += d);
        let first_order = if view.is_ringed { limits.first_order_of_rings } else { limits.first_order };
        if largest > first_order * sigma {
            return Change::Refit;
        }
        view.move_edges(&delta, line);
        Change::Moved
    }
}

fn add_column(sum: &mut BlurSums, job: &ColumnJob<'_>, column: usize, edge: &Edge) {
    let (windows, table) = (job.windows, job.table);
    let Ok(centre) = windows.centre[column] else { return };
    let x = f64::from(windows.side.sign()) * (edge.row_px - f64::from(centre));
    // An edge that has moved since the last frame stands in another part of its window.
    let whole = if x.abs() > f64::from(PHASE_REACH) { x.round() } else { 0.0 };
    let x = (x - whole) as f32;
    let (dark, light) = (job.dark.level[column], job.light.level[column]);
    // What lies outside the core has no weight.
    let (first, length) = table.core();
    let Ok(moved) = usize::try_from(first as i64 + whole as i64) else { return };
    let Some(window) = windows.of(column).get(moved..moved + length) else { return };
    let phase = table.phase(x);
    // The edge was placed by its last step from this phase; `blur_shift` has moved it since.
    let step = x + phase.scalars.lever * job.blur_shift - phase.scalars.phase;
    let seen = dot_above(window, dark, &phase.blur_scores[first..first + length]) / (light - dark);
    let score = seen - phase.blur.offset - step * phase.blur.position;
    let information = phase.blur.information(phase.scalars);
    sum.score += f64::from(score - information * job.blur_shift);
    sum.information += f64::from(information);
    sum.count += 1.0;
}

/// What moves the edges of a side.
pub(crate) struct TrackView<'a> {
    pub(crate) windows: &'a Windows,
    pub(crate) table: &'a Table,
    /// Whether columns are readings one after the other: no course along the field.
    pub(crate) level_lines: bool,
    /// Whether the edges have rings.
    pub(crate) is_ringed: bool,
}

impl TrackView<'_> {
    /// Moves edges by what a change of the blur of every block does to them.
    fn move_edges(&self, delta: &[f64; BLOCKS], line: &mut [Edge]) {
        let columns = line.len();
        let sign = f64::from(self.windows.side.sign());
        for (block, delta) in delta.iter().enumerate() {
            for column in BlurEstimate::columns(block, columns) {
                let Ok(centre) = self.windows.centre[column] else { continue };
                let edge = &mut line[column];
                let x = sign * (edge.row_px - f64::from(centre));
                let phase = if x.abs() > f64::from(PHASE_REACH) { x - x.round() } else { x };
                let lever = f64::from(self.table.scalars(self.table.index(phase as f32)).lever);
                edge.row_px -= sign * lever * delta;
            }
        }
    }
}

#[cfg(test)]
mod tests;
