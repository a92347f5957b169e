//! The transmission over a window of the sensor, and what touches each pixel.
//!
//! Only tiles that something touches are ever written, cleared or need to be read: a clean tile is 1 throughout.

use rayon::prelude::*;

use super::mask::THRESHOLD;

/// Something that dims a rectangle of pixels.
pub(super) trait Thing: Sync {
    /// Bit of the mask.
    fn kind(&self) -> u8;
    /// Rows of the map it touches; may leave the map.
    fn rows(&self) -> std::ops::Range<i64>;
    /// Columns of the map it touches; may leave the map.
    fn columns(&self) -> std::ops::Range<i64>;
    /// Factors of a row's pixels from `column` on, all within its extent and the map.
    fn fill(&self, row: i64, column: i64, out: &mut [f32]);
}

fn multiply(values: &mut [f32], mask: &mut [u8], factors: &[f32], kind: u8) {
    for ((v, m), f) in values.iter_mut().zip(mask).zip(factors) {
        *v *= f;
        *m |= if (f - 1.0).abs() > THRESHOLD { kind } else { 0 };
    }
}

/// Notes the tiles in which a factor is not 1.
fn touch(touched: &mut [bool], from: usize, factors: &[f32]) {
    let mut column = from;
    let mut rest = factors;
    while !rest.is_empty() {
        let (here, after) = rest.split_at((TILE - column % TILE).min(rest.len()));
        touched[column / TILE] |= here.iter().any(|f| *f != 1.0);
        column += here.len();
        rest = after;
    }
}

/// Side of a tile, pixels.
pub const TILE: usize = 32;

/// Factors that multiply the light of every pixel, row-major, and their mask.
#[derive(Clone, Debug, PartialEq)]
pub struct TransmissionMap {
    rows: usize,
    columns: usize,
    values: Vec<f32>,
    mask: Vec<u8>,
    touched: Vec<bool>,
}

impl TransmissionMap {
    /// A clean window.
    pub fn new(rows: usize, columns: usize) -> Self {
        let tiles = rows.div_ceil(TILE) * columns.div_ceil(TILE);
        Self {
            rows,
            columns,
            values: vec![1.0; rows * columns],
            mask: vec![0; rows * columns],
            touched: vec![false; tiles],
        }
    }

    /// Rows of the window.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Columns of the window.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Factor of every pixel, row-major; 1 is clear.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// What touches every pixel: bits of [`super::mask`].
    pub fn mask(&self) -> &[u8] {
        &self.mask
    }

    /// Tiles a row of tiles holds.
    pub fn tile_columns(&self) -> usize {
        self.columns.div_ceil(TILE)
    }

    /// Whether each tile of 32 x 32 pixels is touched, row-major.
    pub fn touched(&self) -> &[bool] {
        &self.touched
    }

    /// Multiplies every pixel by one factor.
    pub fn dim(&mut self, kind: u8, factor: f32) {
        self.values.iter_mut().for_each(|v| *v *= factor);
        if (factor - 1.0).abs() > THRESHOLD {
            self.mask.iter_mut().for_each(|m| *m |= kind);
        }
        self.touched.fill(true);
    }

    /// Multiplies by the factors of all things, in their order. Bands of tiles are independent: the result does not
    /// depend on the number of threads.
    pub(super) fn lay(&mut self, things: &[impl Thing]) {
        let (columns, across) = (self.columns, self.tile_columns());
        if columns == 0 {
            return;
        }
        let bands = self.values.par_chunks_mut(TILE * columns).zip(self.mask.par_chunks_mut(TILE * columns));
        bands.zip(self.touched.par_chunks_mut(across)).enumerate().for_each(
            |(band, ((values, mask), touched))| {
                let first = (band * TILE) as i64;
                let last = first + (values.len() / columns) as i64;
                let mut factors = vec![1.0; columns];
                for thing in things {
                    let (rows, along) = (thing.rows(), thing.columns());
                    let (from, to) = (along.start.max(0), along.end.min(columns as i64));
                    if from >= to {
                        continue;
                    }
                    let factors = &mut factors[..(to - from) as usize];
                    for row in rows.start.max(first)..rows.end.min(last) {
                        thing.fill(row, from, factors);
                        let at = (row - first) as usize * columns + from as usize;
                        let range = at..at + factors.len();
                        multiply(&mut values[range.clone()], &mut mask[range], factors, thing.kind());
                        touch(touched, from as usize, factors);
                    }
                }
            },
        );
    }

    /// Marks pixels without dimming them: a film's rise of the edge.
    pub fn mark(&mut self, column: usize, rows: std::ops::Range<i64>, kind: u8) {
        if column < self.columns {
            for row in rows.start.max(0)..rows.end.min(self.rows as i64) {
                self.mask[row as usize * self.columns + column] |= kind;
            }
        }
    }

    /// Makes this window a copy of `other`, writing only tiles that either of them touches.
    ///
    /// Windows of different sizes are copied whole.
    pub fn copy_from(&mut self, other: &Self) {
        if (self.rows, self.columns) != (other.rows, other.columns) {
            self.clone_from(other);
            return;
        }
        self.mask.copy_from_slice(&other.mask);
        let across = self.tile_columns();
        for tile in 0..self.touched.len() {
            if !self.touched[tile] && !other.touched[tile] {
                continue;
            }
            let (row, column) = (tile / across * TILE, tile % across * TILE);
            let last = (column + TILE).min(self.columns);
            for r in row..(row + TILE).min(self.rows) {
                let range = r * self.columns + column..r * self.columns + last;
                self.values[range.clone()].copy_from_slice(&other.values[range]);
            }
        }
        self.touched.copy_from_slice(&other.touched);
    }
}
