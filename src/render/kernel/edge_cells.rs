//! Light past an edge over a cell of neighbouring columns in one row: [`super::shadowgraph`]'s
//! `transmitted` in lanes.
//!
//! The arithmetic of every lane is the kernel's own, in the kernel's order, so that the results are
//! the same bits. Only the table look-up remains one load per pixel; everything before and after it
//! vectorises.

use super::column_edges::{Edge, PROFILE};
use super::job::Job;
use super::light_map::floor_to_u32;
use super::shadowgraph::transmitted;

/// Columns of a cell, the light map's.
pub(crate) use super::light_map::CELL;

/// One edge of neighbouring columns, one value per lane.
#[derive(Clone, Debug)]
pub(crate) struct EdgeCell {
    /// First row of the column's band; a lane beyond the frame has none.
    start: [i32; CELL],
    /// Integer part of the edge's row.
    pub(crate) whole: [i32; CELL],
    part: [f32; CELL],
    across: [f32; CELL],
    along: [f32; CELL],
    blend: [f32; CELL],
    /// First segment of the edge's table.
    segment: [u32; CELL],
    /// Whether every edge is read from a table.
    straight: bool,
    /// Rows in which a lane lies in its band.
    rows: std::ops::Range<i32>,
}

impl EdgeCell {
    /// The edges of `side` (0 upper, 1 lower) of the columns from `first` on.
    fn new(job: &Job<'_>, first: usize, side: usize) -> Self {
        let count = CELL.min(job.columns.len() - first);
        let group = job.columns.len().div_ceil(job.bands.start.len().max(1)).max(1);
        let lane = |i: usize| first + i.min(count - 1);
        let edge = |i: usize| edge_of(job, lane(i), side);
        let band_rows = job.params.edge.band_rows as i32;
        let start = |i: usize| job.bands.start[lane(i) / group][side];
        let starts = (0..count).map(start);
        let from = starts.clone().min().unwrap_or(0);
        let to = starts.max().unwrap_or(0).saturating_add(band_rows);
        Self {
            start: std::array::from_fn(|i| if i < count { start(i) } else { i32::MAX }),
            whole: std::array::from_fn(|i| edge(i).whole),
            part: std::array::from_fn(|i| edge(i).part),
            across: std::array::from_fn(|i| edge(i).across),
            along: std::array::from_fn(|i| edge(i).along),
            blend: std::array::from_fn(|i| edge(i).blend),
            segment: std::array::from_fn(|i| edge(i).table.wrapping_mul(job.params.edge.segments)),
            straight: (0..count).all(|i| edge(i).table < PROFILE),
            rows: from..to,
        }
    }

    /// Whether a lane lies in its band in this row.
    #[inline(always)]
    pub(crate) fn touches(&self, row: i32) -> bool {
        self.rows.contains(&row)
    }

    /// Whether a lane's pixel of this row lies in its band.
    #[inline(always)]
    pub(crate) fn in_band(&self, lane: usize, row: i32, band_rows: u32) -> bool {
        (row.wrapping_sub(self.start[lane]) as u32) < band_rows
    }

    /// Share of the light on the pixels of a row past the edges of the columns from `first` on.
    #[inline(always)]
    pub(crate) fn light(&self, job: &Job<'_>, at: (usize, usize), row: i32, out: &mut [f32; CELL]) {
        *out = [0.0; CELL];
        if !self.straight {
            let (first, side) = at;
            let count = CELL.min(job.columns.len() - first);
            for (i, light) in out[..count].iter_mut().enumerate() {
                *light = transmitted(job, edge_of(job, first + i, side), row);
            }
            return;
        }
        let mut centre = [0.0f32; CELL];
        for (i, centre) in centre.iter_mut().enumerate() {
            *centre = (row.wrapping_sub(self.whole[i]) as f32 - self.part[i]) * self.across[i];
        }
        for node in &job.quadrature {
            let mut u = [0.0f32; CELL];
            for i in 0..CELL {
                u[i] = (centre[i] + node.down * self.across[i]) + node.along * self.along[i];
            }
            let mut light = edge_spreads(job, &u, &self.segment, 0);
            if job.stacked {
                let next = edge_spreads(job, &u, &self.segment, job.params.edge.segments);
                for i in 0..CELL {
                    light[i] += self.blend[i] * (next[i] - light[i]);
                }
            }
            for i in 0..CELL {
                out[i] += node.weight * light[i];
            }
        }
    }
}

#[inline(always)]
fn edge_of<'a>(job: &'a Job<'_>, column: usize, side: usize) -> &'a Edge {
    let c = &job.columns[column];
    if side == 0 { &c.top } else { &c.bottom }
}

/// `edge_spread` of the kernel for every lane.
#[inline(always)]
fn edge_spreads(job: &Job<'_>, u: &[f32; CELL], tables: &[u32; CELL], skip: u32) -> [f32; CELL] {
    let params = &job.params;
    let (segments, last) = (params.edge.segments as f32, params.edge.segments - 1);
    let (mut t, mut index) = ([0.0f32; CELL], [0u32; CELL]);
    for i in 0..CELL {
        let place = (u[i] + params.edge.reach) * params.edge.per_unit;
        // Plain comparisons: `f32::max` and `min` handle NaN, which costs three instructions.
        let place = if place > 0.0 { place } else { 0.0 };
        let place = if place < segments { place } else { segments };
        let segment = floor_to_u32(place).min(last);
        t[i] = place - segment as i32 as f32;
        index[i] = tables[i].wrapping_add(skip).wrapping_add(segment);
    }
    let mut c = [[0.0f32; 4]; CELL];
    for i in 0..CELL {
        c[i] = job.esf.segments[index[i] as usize];
    }
    let mut light = [0.0f32; CELL];
    for i in 0..CELL {
        light[i] = c[i][0] + t[i] * (c[i][1] + t[i] * (c[i][2] + t[i] * c[i][3]));
    }
    light
}

/// Upper and lower edges of all columns.
pub(crate) fn edge_cells(job: &Job<'_>) -> Vec<[EdgeCell; 2]> {
    (0..job.columns.len())
        .step_by(CELL)
        .map(|first| [EdgeCell::new(job, first, 0), EdgeCell::new(job, first, 1)])
        .collect()
}
