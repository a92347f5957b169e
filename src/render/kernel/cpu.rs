//! CPU twin of `shaders/shadowgraph.wgsl`, blocks of pixels: a frame, rows and blocks of a row in
//! the shader's order.
//!
//! Rust never fuses or reorders floating-point operations, so SSE2, AVX2 and AVX-512 give the same
//! bits; the wider ones are chosen at run time.

use multiversion::multiversion;
use rayon::prelude::*;

use super::edge_cells::{CELL, EdgeCell, edge_cells};
use super::job::Job;
use super::light_map::LightMap;
use super::params::Params;
use super::shadowgraph::{
    Pixel, field_light, fixed_pattern, hash, noise_polynomial, row_key, sample, sensor_row, standard_normal,
};

/// Columns treated together: their counts stay in the first-level cache.
const BLOCK: usize = 256;

/// Rows per task of the thread pool.
const TASK_ROWS: usize = 16;

/// Standard normal deviates of a block of a row.
#[inline(always)]
fn deviates(key: [u32; 2], first: u32, z: &mut [f32; BLOCK]) {
    for (i, z) in z.iter_mut().enumerate() {
        *z = standard_normal(hash(key, first.wrapping_add(i as u32)));
    }
}

/// Counts of pixels far from the edges: one block of a row.
#[inline(always)]
fn flat_pixels(
    params: &Params,
    cells: &[[EdgeCell; 2]],
    row: i32,
    z: &[f32; BLOCK],
    counts: &mut [f32; BLOCK],
) {
    let (bright, shadow) = (params.flat.bright, params.flat.shadow);
    for ((out, z), cells) in counts.chunks_exact_mut(CELL).zip(z.chunks_exact(CELL)).zip(cells) {
        let inside = between(cells, row);
        for i in 0..CELL {
            let k = std::array::from_fn(|n| if inside[i] { shadow[n] } else { bright[n] });
            out[i] = sample(k, z[i]);
        }
    }
}

/// Which lanes of a row lie in the shadow.
#[inline(always)]
fn between([top, bottom]: &[EdgeCell; 2], row: i32) -> [bool; CELL] {
    std::array::from_fn(|i| (row > top.whole[i]) & (row < bottom.whole[i]))
}

/// Counts where every column of the block is on the same side of its edges.
#[inline(always)]
fn even_pixels(k: [f32; 4], z: &[f32; BLOCK], counts: &mut [f32; BLOCK]) {
    for i in 0..BLOCK {
        counts[i] = sample(k, z[i]);
    }
}

/// The fixed pattern of neighbouring pixels of known means.
#[inline(always)]
fn pattern_pixels<const N: usize>(params: &Params, at: At, means: &[f32; N], counts: &mut [f32; N]) {
    let key = row_key(params.keys.pattern, sensor_row(params, at.row as u32));
    for i in 0..N {
        let column = (params.place.column0 + at.column as u32).wrapping_add(i as u32);
        counts[i] += fixed_pattern(params, means[i], key, column);
    }
}

/// Mean grey values of a block of flat pixels.
#[inline(always)]
fn flat_means(job: &Job<'_>, place: Place<'_>, row: i32, factors: &[f32; BLOCK], means: &mut [f32; BLOCK]) {
    let params = &job.params;
    match place.extent.even(row) {
        Some(false) => means.fill(params.signal.shadow),
        Some(true) => {
            for i in 0..BLOCK {
                means[i] = params.signal.shadow + params.signal.contrast * factors[i];
            }
        }
        None => {
            let lanes = means.chunks_exact_mut(CELL).zip(factors.chunks_exact(CELL));
            for ((means, factors), cells) in lanes.zip(place.cells) {
                let inside = between(cells, row);
                for i in 0..CELL {
                    means[i] = params.signal.shadow
                        + if inside[i] { 0.0 } else { params.signal.contrast * factors[i] };
                }
            }
        }
    }
}

/// Light of the bright field over neighbouring pixels of a row, 1 where it is even and clear.
#[inline(always)]
fn field_factors<const N: usize>(job: &Job<'_>, at: At, factors: &mut [f32; N]) {
    let params = &job.params;
    let row = sensor_row(params, at.row as u32);
    let count = N.min(job.columns.len() - at.column);
    for (i, factor) in factors.iter_mut().enumerate() {
        *factor = field_light(params, row, (params.place.column0 + at.column as u32).wrapping_add(i as u32));
    }
    let Some(map) = job.contamination.as_ref().filter(|_| params.light.kind > 1) else { return };
    clear_light(job, map, at, &mut factors[..count]);
}

/// Multiplies by the transmission of the contamination; clean cells are skipped.
#[inline(always)]
fn clear_light(job: &Job<'_>, map: &LightMap, at: At, factors: &mut [f32]) {
    let (row, count) = (at.row as usize, factors.len());
    let first = row * job.params.light.words as usize + at.column / 2;
    let words = &map.words[first..first + count.div_ceil(2)];
    for (i, (factors, words)) in factors.chunks_mut(CELL).zip(words.chunks(CELL / 2)).enumerate() {
        if !map.is_touched(row, at.column + i * CELL) {
            continue;
        }
        for (pair, word) in factors.chunks_mut(2).zip(words) {
            for (i, factor) in pair.iter_mut().enumerate() {
                *factor *= ((word >> (16 * i)) & 0xffff) as i32 as f32 * 3.051_757_8e-5;
            }
        }
    }
}

/// Counts of neighbouring pixels, each with its own mean.
#[inline(always)]
fn pixels<const N: usize>(job: &Job<'_>, at: At, means: &[f32; N], z: &[f32; N], counts: &mut [f32; N]) {
    for i in 0..N {
        counts[i] = sample(noise_polynomial(&job.params, means[i]), z[i]);
    }
    if job.params.pixels.pattern != 0 {
        pattern_pixels(&job.params, at, means, counts);
    }
}

/// Counts of a block of a row, far from the edges.
#[inline(always)]
fn fill_block(job: &Job<'_>, place: Place<'_>, at: At, z: &[f32; BLOCK], counts: &mut [f32; BLOCK]) {
    let params = &job.params;
    let even = place.extent.even(at.row);
    if params.light.kind != 0 && even != Some(false) {
        let (mut factors, mut means) = ([1.0; BLOCK], [params.signal.shadow; BLOCK]);
        field_factors(job, at, &mut factors);
        flat_means(job, place, at.row, &factors, &mut means);
        return pixels(job, at, &means, z, counts);
    }
    match even {
        Some(lit) => even_pixels(if lit { params.flat.bright } else { params.flat.shadow }, z, counts),
        None => flat_pixels(params, place.cells, at.row, z, counts),
    }
    if params.pixels.pattern != 0 {
        let mut means = [params.signal.shadow; BLOCK];
        flat_means(job, place, at.row, &[1.0; BLOCK], &mut means);
        pattern_pixels(params, at, &means, counts);
    }
}

/// Overwrites the counts of a cell's pixels that one of its edges affects; the other edge adds
/// light only where the two bands overlap.
#[inline(always)]
fn edge_pixels(job: &Job<'_>, edge: CellSide<'_>, at: At, z: &[f32; CELL], counts: &mut [f32; CELL]) {
    let CellSide { cells, side } = edge;
    let params = &job.params;
    let (mut light, mut means, mut near) = ([0.0; CELL], [0.0; CELL], [0.0; CELL]);
    cells[side].light(job, (at.column, side), at.row, &mut light);
    if params.pixels.overlap != 0 {
        let mut other = [0.0; CELL];
        cells[1 - side].light(job, (at.column, 1 - side), at.row, &mut other);
        for i in 0..CELL {
            light[i] += other[i];
        }
    }
    if params.light.kind != 0 {
        let mut factors = [1.0; CELL];
        field_factors(job, at, &mut factors);
        for i in 0..CELL {
            light[i] *= factors[i];
        }
    }
    for i in 0..CELL {
        means[i] = params.signal.shadow + params.signal.contrast * light[i];
    }
    pixels(job, at, &means, z, &mut near);
    for i in 0..CELL {
        if cells[side].in_band(i, at.row, params.edge.band_rows) {
            counts[i] = near[i];
        }
    }
}

/// A position in the frame.
#[derive(Clone, Copy)]
struct At {
    row: i32,
    column: usize,
}

/// One of the two edges in a cell.
#[derive(Clone, Copy)]
struct CellSide<'a> {
    cells: &'a [EdgeCell; 2],
    side: usize,
}

/// A block's edges.
#[derive(Clone, Copy)]
struct Place<'a> {
    extent: &'a BlockExtent,
    cells: &'a [[EdgeCell; 2]],
}

/// Extent of the edges of a block of columns: rows outside `clear` may contain an edge.
struct BlockExtent {
    top: (i32, i32),
    bottom: (i32, i32),
}

impl BlockExtent {
    fn new(job: &Job<'_>, first: usize) -> Self {
        let last = (first + BLOCK).min(job.columns.len());
        let mut extent = Self { top: (i32::MAX, i32::MIN), bottom: (i32::MAX, i32::MIN) };
        for c in &job.columns[first..last] {
            extent.top = (extent.top.0.min(c.top.whole), extent.top.1.max(c.top.whole));
            extent.bottom = (extent.bottom.0.min(c.bottom.whole), extent.bottom.1.max(c.bottom.whole));
        }
        extent
    }

    /// Whether the whole block lies in the light (`true`) or in the shadow (`false`) in this row;
    /// `None` for neither.
    fn even(&self, row: i32) -> Option<bool> {
        if row <= self.top.0 || row >= self.bottom.1 {
            return Some(true);
        }
        (row > self.top.1 && row < self.bottom.0).then_some(false)
    }
}

/// Data of the blocks of a frame, common to all rows.
struct Blocks {
    extents: Vec<BlockExtent>,
    cells: Vec<[EdgeCell; 2]>,
}

/// Renders a frame into `out`, row-major, `rows * columns` pixels, on the current thread pool.
pub(crate) fn render<P: Pixel>(job: &Job<'_>, out: &mut [P]) {
    let columns = job.params.size.columns as usize;
    let extents = (0..columns).step_by(BLOCK).map(|first| BlockExtent::new(job, first)).collect();
    let blocks = Blocks { extents, cells: edge_cells(job) };
    out.par_chunks_mut(columns * TASK_ROWS).enumerate().for_each(|(task, rows)| {
        fill_rows(job, &blocks, task * TASK_ROWS, rows);
    });
}

/// Rows `first..` of a frame, in the widest instruction set of the machine.
#[multiversion(
    targets("x86_64+avx2+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2", "aarch64+neon"),
    dispatcher = "direct"
)]
fn fill_rows<P: Pixel>(job: &Job<'_>, blocks: &Blocks, first: usize, out: &mut [P]) {
    let columns = job.params.size.columns as usize;
    let (mut counts, mut z) = ([0.0f32; BLOCK], [0.0f32; BLOCK]);
    for (r, line) in out.chunks_exact_mut(columns).enumerate() {
        let row = (first + r) as i32;
        let key = row_key(job.params.keys.noise, sensor_row(&job.params, row as u32));
        for (block, pixels) in line.chunks_mut(BLOCK).enumerate() {
            let at = At { row, column: block * BLOCK };
            let cells = &blocks.cells[at.column / CELL..];
            let place =
                Place { extent: &blocks.extents[block], cells: &cells[..cells.len().min(BLOCK / CELL)] };
            deviates(key, job.params.place.column0 + at.column as u32, &mut z);
            fill_block(job, place, at, &z, &mut counts);
            fill_edges(job, place.cells, at, &z, &mut counts);
            for (pixel, c) in pixels.iter_mut().zip(&counts) {
                *pixel = P::from_counts(&job.params, *c);
            }
        }
    }
}

/// Overwrites the pixels of a block of a row that an edge affects.
#[inline(always)]
fn fill_edges(job: &Job<'_>, cells: &[[EdgeCell; 2]], at: At, z: &[f32; BLOCK], counts: &mut [f32; BLOCK]) {
    let (z, _) = z.as_chunks::<CELL>();
    let (counts, _) = counts.as_chunks_mut::<CELL>();
    for (i, ((cells, z), counts)) in cells.iter().zip(z).zip(counts).enumerate() {
        // The compiler moves the computation common to both sides before their loop; this check
        // skips it where there is no edge.
        if !cells.iter().any(|c| c.touches(at.row)) {
            continue;
        }
        for side in 0..2 {
            if cells[side].touches(at.row) {
                let at = At { column: at.column + i * CELL, ..at };
                edge_pixels(job, CellSide { cells, side }, at, z, counts);
            }
        }
    }
}

/// Writes one value into every pixel: the write floor.
pub(crate) fn constant<P: Pixel>(job: &Job<'_>, out: &mut [P]) {
    let value = P::from_counts(&job.params, job.params.size.words as f32);
    let columns = job.params.size.columns as usize;
    out.par_chunks_mut(columns * TASK_ROWS).for_each(|rows| rows.fill(value));
}
