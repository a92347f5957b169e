//! The transmission over a window of the sensor, and the mask of each pixel.
//!
//! Only affected tiles are ever written, cleared or read: a clean tile is 1 throughout.

use rayon::prelude::*;

use super::shading::Layers;
use super::tiles::{Band, TILE};

/// Factors that multiply the light of every pixel, row-major, and their mask.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TransmissionMap {
    rows: usize,
    columns: usize,
    values: Vec<f32>,
    mask: Vec<u8>,
    touched: Vec<bool>,
}

impl TransmissionMap {
    /// A clean window.
    pub(crate) fn new(rows: usize, columns: usize) -> Self {
        let tiles = rows.div_ceil(TILE) * columns.div_ceil(TILE);
        Self {
            rows,
            columns,
            values: vec![1.0; rows * columns],
            mask: vec![0; rows * columns],
            touched: vec![false; tiles],
        }
    }

    /// Factor of every pixel, row-major; 1 is clear.
    pub(crate) fn values(&self) -> &[f32] {
        &self.values
    }

    /// Mask of every pixel: bits of [`super::mask`].
    #[cfg(test)]
    pub(crate) fn mask(&self) -> &[u8] {
        &self.mask
    }

    /// Number of tiles in a row of tiles.
    pub(crate) fn tile_columns(&self) -> usize {
        self.columns.div_ceil(TILE)
    }

    /// Whether each tile of 32 x 32 pixels is affected, row-major.
    #[cfg(test)]
    pub(crate) fn touched(&self) -> &[bool] {
        &self.touched
    }

    /// Multiplies by the factors of all layers, in their order. Bands of tiles are independent: the
    /// result does not depend on the number of threads.
    pub(super) fn shade(&mut self, layers: &Layers<'_>) {
        let (columns, across) = (self.columns, self.tile_columns());
        if columns == 0 {
            return;
        }
        let bands = self.values.par_chunks_mut(TILE * columns).zip(self.mask.par_chunks_mut(TILE * columns));
        bands.zip(self.touched.par_chunks_mut(across)).enumerate().for_each(
            |(band, ((values, mask), touched))| {
                let first = (band * TILE) as i64;
                layers.shade(&mut Band { first, columns, values, mask: Some(mask), touched });
            },
        );
    }

    /// Makes this window a copy of `other`, writing only tiles that are affected in either.
    ///
    /// Windows of different sizes are copied whole.
    #[cfg(test)]
    pub(crate) fn copy_from(&mut self, other: &Self) {
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
