//! From the light of a frame to its counts on the host, for sensors whose rows and columns share
//! noise or pattern, or whose readout is not linear.
//!
//! The kernel (device or twin) draws the mean grey values without noise, in f32, one pixel further
//! at every border that has a neighbour; this pass adds what the sensor does. Both backends pass
//! through the same host code, so that they stay equal where their means are. In this order, each
//! in f32 and the order written here:
//!
//! ```text
//! m  = mean after cross-talk with the four neighbours (the border's own value where there is none)
//! c  = k0 + k1·z + k2·z² + k3·z³ + row noise                 the kernel's noise, `noise`
//! c += pixel pattern + (m - black)·(row gain + column gain) + row offset + column offset
//! s  = min(c, full well) - black,   counts = black + s·(1 + s·(quadratic + s·cubic))
//! ```

use multiversion::multiversion;
use rayon::prelude::*;

use super::params::Params;
use super::readout_terms::{Readout, Response, RowTerms};
use super::shadowgraph::{Pixel, fixed_pattern, hash, noise_polynomial, row_key, sample, standard_normal};

/// Columns treated together: their counts stay in the first-level cache.
const BLOCK: usize = 256;

/// Rows per task of the thread pool.
const TASK_ROWS: usize = 16;

/// Means of a frame as the kernel drew them, row-major.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DrawnMeans<'a> {
    pub(crate) counts: &'a [f32],
    pub(crate) rows: usize,
    pub(crate) columns: usize,
}

impl<'a> DrawnMeans<'a> {
    fn row(&self, row: usize) -> &'a [f32] {
        &self.counts[row * self.columns..(row + 1) * self.columns]
    }
}

/// Three rows of means, the middle one that of the frame's row.
#[derive(Clone, Copy)]
struct Neighbours<'a> {
    above: &'a [f32],
    here: &'a [f32],
    below: &'a [f32],
}

impl<'a> Neighbours<'a> {
    fn of(drawn: &DrawnMeans<'a>, row: usize) -> Self {
        let last = drawn.rows - 1;
        Self {
            above: drawn.row(row.saturating_sub(1)),
            here: drawn.row(row),
            below: drawn.row((row + 1).min(last)),
        }
    }

    /// Mean of a pixel after cross-talk.
    #[inline(always)]
    fn mixed(&self, response: &Response, column: usize) -> f32 {
        let m = self.here[column];
        let left = self.here[column.saturating_sub(1)];
        let right = self.here[(column + 1).min(self.here.len() - 1)];
        m + response.along * ((left - m) + (right - m))
            + response.down * ((self.above[column] - m) + (self.below[column] - m))
    }
}

/// Counts after the full well and the response.
#[inline(always)]
fn responded(params: &Params, response: &Response, counts: f32) -> f32 {
    let over = counts - params.signal.black;
    let s = if over < response.full_well { over } else { response.full_well };
    params.signal.black + s * (1.0 + s * (response.quadratic + s * response.cubic))
}

/// Reads a frame out of its means into `out`, row-major, on the current thread pool.
pub(crate) fn read_out<P: Pixel>(readout: &Readout, drawn: &DrawnMeans<'_>, out: &mut [P]) {
    let columns = readout.column_gain.len();
    out.par_chunks_mut(columns * TASK_ROWS).zip(readout.rows.par_chunks(TASK_ROWS)).for_each(
        |(lines, rows)| {
            for (line, row) in lines.chunks_exact_mut(columns).zip(rows) {
                read_row(readout, row, Neighbours::of(drawn, row.drawn), line);
            }
        },
    );
}

/// A row of the frame, in the widest instruction set of the machine.
#[multiversion(
    targets("x86_64+avx2+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2", "aarch64+neon"),
    dispatcher = "direct"
)]
fn read_row<P: Pixel>(readout: &Readout, row: &RowTerms, near: Neighbours<'_>, line: &mut [P]) {
    let params = &readout.params;
    let key = row_key(params.keys.noise, row.sensor);
    let pattern = row_key(params.keys.pattern, row.sensor);
    let mut means = [0.0f32; BLOCK];
    for (block, pixels) in line.chunks_mut(BLOCK).enumerate() {
        let first = block * BLOCK;
        for (i, mean) in means[..pixels.len()].iter_mut().enumerate() {
            *mean = near.mixed(&readout.response, readout.first_column + first + i);
        }
        let gains = &readout.column_gain[first..first + pixels.len()];
        let offsets = &readout.column_offset[first..first + pixels.len()];
        let column0 = params.place.column0 + first as u32;
        for i in 0..pixels.len() {
            let column = column0.wrapping_add(i as u32);
            let mean = means[i];
            let z = standard_normal(hash(key, column));
            let mut counts = sample(noise_polynomial(params, mean), z);
            if params.pixels.pattern != 0 {
                counts += fixed_pattern(params, mean, pattern, column);
            }
            counts += (mean - params.signal.black) * (row.gain + gains[i]) + (row.offset + offsets[i]);
            pixels[i] = P::from_counts(params, responded(params, &readout.response, counts));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crosstalk_moves_light_to_the_neighbours_and_loses_none_inside() {
        let mut counts = vec![0.0f32; 25];
        counts[12] = 100.0;
        let drawn = DrawnMeans { counts: &counts, rows: 5, columns: 5 };
        let response = Response { along: 0.02, down: 0.05, ..Response::default() };
        let seen: Vec<f32> = (0..5)
            .flat_map(|r| (0..5).map(move |c| (r, c)))
            .map(|(r, c)| Neighbours::of(&drawn, r).mixed(&response, c))
            .collect();
        assert_eq!((seen[11], seen[13], seen[7], seen[17]), (2.0, 2.0, 5.0, 5.0));
        assert!((seen[12] - 86.0).abs() < 1e-5 && (seen.iter().sum::<f32>() - 100.0).abs() < 1e-4);
        // A level field stays level up to its borders.
        let level = DrawnMeans { counts: &[7.0; 6], rows: 2, columns: 3 };
        assert!((0..3).all(|c| Neighbours::of(&level, 1).mixed(&response, c) == 7.0));
    }

    #[test]
    fn the_response_is_the_polynomial_and_the_well_clips_before_it() {
        let mut params: Params = bytemuck::Zeroable::zeroed();
        params.signal.black = 64.0;
        let response = Response {
            full_well: 4000.0,
            quadratic: -0.02 / 4000.0,
            cubic: 0.01 / 1.6e7,
            ..Response::default()
        };
        assert_eq!(responded(&params, &response, 64.0), 64.0);
        let half = 2000.0 * (1.0 - 0.01 + 0.0025);
        assert!((responded(&params, &response, 2064.0) - (64.0 + half)).abs() < 1e-3);
        let full = 4000.0 * 0.99;
        assert!((responded(&params, &response, 9999.0) - (64.0 + full)).abs() < 1e-3);
    }
}
