//! Contamination multiplied into bands of tiles while they are in the cache, then packed, without
//! an f32 map of the whole field.

use rayon::prelude::*;

use super::shading::Layers;
use super::tiles::{Band, TILE, TransmissionRequest};
use crate::render::kernel::light_map::{LightMap, Lines};
use multiversion::multiversion;

/// Factors and mask of a tile.
#[derive(Clone, Debug)]
struct Tile {
    values: [f32; TILE * TILE],
    mask: [u8; TILE * TILE],
}

/// The factors that are constant over a stream, on the full sensor: only the affected tiles.
#[derive(Clone, Debug, Default)]
pub(super) struct CachedTiles {
    tiles: Vec<Option<Box<Tile>>>,
}

/// Buffers of one band.
struct Scratch {
    values: Vec<f32>,
    dimmed: Vec<bool>,
}

impl Scratch {
    fn new(columns: usize) -> Self {
        Self { values: vec![1.0; TILE * columns], dimmed: vec![false; columns.div_ceil(TILE)] }
    }
}

/// Rows of a tile within a band: indices in the band and in the tile.
fn lines(
    tile: usize,
    columns: usize,
    rows: usize,
) -> impl Iterator<Item = (std::ops::Range<usize>, std::ops::Range<usize>)> {
    let (first, last) = (tile * TILE, (tile * TILE + TILE).min(columns));
    (0..rows).map(move |r| (r * columns + first..r * columns + last, r * TILE..r * TILE + last - first))
}

impl CachedTiles {
    /// Multiplies the layers over a sensor and stores the affected tiles.
    pub(super) fn new(layers: &Layers<'_>, rows: usize, columns: usize) -> Self {
        let band = |(values, mask, dimmed): &mut (Vec<f32>, Vec<u8>, Vec<bool>), first: usize| {
            let here = TILE.min(rows - first);
            let size = here * columns;
            layers.shade(&mut Band {
                first: first as i64,
                columns,
                values: &mut values[..size],
                mask: Some(&mut mask[..size]),
                touched: dimmed,
            });
            let mut kept = Vec::with_capacity(dimmed.len());
            for (tile, dimmed) in dimmed.iter_mut().enumerate() {
                kept.push(std::mem::take(dimmed).then(|| {
                    let mut one = Box::new(Tile { values: [1.0; TILE * TILE], mask: [0; TILE * TILE] });
                    for (from, to) in lines(tile, columns, here) {
                        one.values[to.clone()].copy_from_slice(&values[from.clone()]);
                        one.mask[to].copy_from_slice(&mask[from.clone()]);
                        values[from.clone()].fill(1.0);
                        mask[from].fill(0);
                    }
                    one
                }));
            }
            kept
        };
        let size = TILE * columns;
        let fresh = || (vec![1.0; size], vec![0; size], vec![false; columns.div_ceil(TILE)]);
        let firsts: Vec<usize> = (0..rows).step_by(TILE).collect();
        let bands: Vec<Vec<_>> =
            firsts.into_par_iter().map_init(fresh, |kept, first| band(kept, first)).collect();
        Self { tiles: bands.into_iter().flatten().collect() }
    }

    /// Copies the tiles of a band into a clear one.
    fn copy_into(&self, band: &mut Band<'_>) {
        let across = band.columns.div_ceil(TILE);
        let rows = band.values.len() / band.columns;
        let first = band.first as usize / TILE * across;
        for (tile, kept) in self.tiles[first..first + across].iter().enumerate() {
            let Some(kept) = kept else { continue };
            band.touched[tile] = true;
            for (to, from) in lines(tile, band.columns, rows) {
                band.values[to.clone()].copy_from_slice(&kept.values[from.clone()]);
                if let Some(mask) = &mut band.mask {
                    mask[to].copy_from_slice(&kept.mask[from]);
                }
            }
        }
    }
}

/// Multiplies the layers, one after the other, onto the stored tiles, and packs the factors of
/// every visible band. Bands are independent: the result does not depend on the number of threads.
pub(super) fn shade_packed(
    kept: Option<&CachedTiles>,
    layers: &[Layers<'_>],
    request: &TransmissionRequest,
    out: &mut LightMap,
) {
    let [rows, columns] = request.size;
    out.prepare(rows, columns, request.with_mask);
    if rows == 0 || columns == 0 {
        return;
    }
    let mut masks: Vec<Option<&mut [u8]>> = out.mask.chunks_mut(TILE * columns).map(Some).collect();
    masks.resize_with(rows.div_ceil(TILE), || None);
    let words = out.words.par_chunks_mut(TILE * columns.div_ceil(2));
    let touched = out.touched.par_chunks_mut(TILE * columns.div_ceil(TILE));
    let bands = words.zip(touched).zip(masks).enumerate();
    bands.for_each_init(
        || Scratch::new(columns),
        |scratch, (band, ((words, touched), mask))| {
            let Scratch { values, dimmed } = scratch;
            let (first, last) = (band * TILE, rows.min(band * TILE + TILE));
            if request.unseen.start <= first as i32 && last as i32 <= request.unseen.end {
                return;
            }
            let size = (last - first) * columns;
            let values = &mut values[..size];
            let mut laid = Band { first: first as i64, columns, values, mask, touched: dimmed };
            if let Some(kept) = kept {
                kept.copy_into(&mut laid);
            }
            layers.iter().for_each(|layer| layer.shade(&mut laid));
            finish(&mut Lines { words, touched, columns }, laid.values, laid.touched);
        },
    );
}

/// Packs a band and clears it for the next.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"), dispatcher = "direct")]
fn finish(lines_out: &mut Lines<'_>, values: &mut [f32], dimmed: &mut [bool]) {
    lines_out.pack(values, dimmed);
    let (columns, rows) = (lines_out.columns, values.len() / lines_out.columns);
    for (tile, dimmed) in dimmed.iter_mut().enumerate() {
        if std::mem::take(dimmed) {
            for (place, _) in lines(tile, columns, rows) {
                values[place].fill(1.0);
            }
        }
    }
}
