//! CPU twin of `shaders/shadowgraph.wgsl`: same names, same order, same arithmetic in f32.
//!
//! Rust never fuses or reorders floating-point operations, so SSE2, AVX2 and AVX-512 give the same bits; the wider
//! ones are chosen at run time.

use multiversion::multiversion;
use rayon::prelude::*;

use super::column_edges::{Edge, PROFILE};
use super::edge_cells::{CELL, EdgeCell, edge_cells};
use super::light_map::LightMap;
use super::noise::{DENOMINATOR, NUMERATOR};
use super::params::{Job, Params};

/// Columns treated together: their counts stay in the first-level cache.
const BLOCK: usize = 256;

/// Rows a task of the thread pool.
const TASK_ROWS: usize = 16;

/// Row of the sensor that a row of the frame shows: a second window may follow the first.
#[inline(always)]
fn sensor_row(params: &Params, row: u32) -> u32 {
    params.row0 + row + if row >= params.split { params.skip } else { 0 }
}

/// Keys of a sensor row from those of the frame: one of them is different in every row.
#[inline(always)]
fn row_key(key: [u32; 2], row: u32) -> [u32; 2] {
    let mut x = row ^ key[0];
    x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    [x ^ (x >> 16), x.wrapping_add(key[1])]
}

/// 32 random bits of a pixel.
#[inline(always)]
fn hash(key: [u32; 2], column: u32) -> u32 {
    let mut x = column.wrapping_mul(0x9e37_79b9) ^ key[0];
    x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    x = x.wrapping_add(key[1]);
    x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// A standard normal deviate from 32 bits: two 16-bit numbers add up to a triangular one, which is bent.
#[inline(always)]
pub fn standard_normal(bits: u32) -> f32 {
    let [p0, p1, p2, p3, p4] = NUMERATOR;
    let [q1, q2, q3] = DENOMINATOR;
    let v = (bits >> 16) as i32 + (bits & 0xffff) as i32 - 65535;
    let x = v as f32 * 1.525_878_9e-5;
    let u = 1.0 - x.abs();
    let p = p0 + u * (p1 + u * (p2 + u * (p3 + u * p4)));
    let q = 1.0 + u * (q1 + u * (q2 + u * q3));
    x * (p / q)
}

/// The larger one; that of f32 minds NaN, which costs three instructions.
#[inline(always)]
fn most(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Integer part of a number from 0 to 2²²: adding 2²³ rounds it, which vectorises where a conversion that saturates does not.
#[inline(always)]
pub(crate) fn whole(x: f32) -> u32 {
    let rounded = x + 8_388_608.0;
    let over = u32::from(rounded - 8_388_608.0 > x);
    (rounded.to_bits() & 0x007f_ffff) - over
}

/// Coefficients of counts = k0 + k1 z + k2 z² + k3 z³ about a mean grey value.
#[inline(always)]
pub fn shaped(params: &Params, mean: f32) -> [f32; 4] {
    let electrons = most((mean - params.black) * params.electrons_per_count, 0.0);
    let variance = most(params.read_variance + electrons, 1e-6);
    let inverse = 1.0 / variance;
    let sd = params.noise * variance.sqrt() * params.counts_per_electron;
    let ratio = electrons * inverse;
    let kurtosis = ratio * inverse;
    let skew2 = ratio * kurtosis;
    let k2 = params.noise * params.counts_per_electron * 0.166_666_67 * ratio;
    let k1 = sd * (1.0 - kurtosis * 0.125 + skew2 * 0.138_888_9);
    let k3 = sd * (kurtosis * 0.041_666_668 - skew2 * 0.055_555_556);
    [mean - k2, k1, k2, k3]
}

#[inline(always)]
fn sample(k: [f32; 4], z: f32) -> f32 {
    k[0] + z * (k[1] + z * (k[2] + z * k[3]))
}

/// What the sensor's fixed pattern adds to a mean grey value: gain, offset and hot pixels, the same in every frame.
#[inline(always)]
fn fixed_pattern(params: &Params, mean: f32, key: [u32; 2], column: u32) -> f32 {
    let a = hash(key, column);
    let b = hash([key[1], key[0]], column);
    let response = params.prnu * (mean - params.black) * standard_normal(a);
    let dark = params.dsnu * standard_normal(b);
    let hot = if a.wrapping_add(b).wrapping_mul(0x9e37_79b9) < params.hot_share { params.hot } else { 0.0 };
    response + dark + hot
}

/// Counts as bits: rounded half to even by adding 1.5·2²³, then clamped as integers.
#[inline(always)]
fn quantise(params: &Params, counts: f32) -> u32 {
    ((counts.min(params.ceiling) + 12_582_912.0).to_bits() as i32)
        .wrapping_sub(0x4b40_0000)
        .clamp(0, params.most) as u32
}

/// Share of the light at u, by one tabulated edge-spread function.
#[inline(always)]
fn edge_spread(params: &Params, esf: &[[f32; 4]], u: f32, table: u32) -> f32 {
    let place = ((u + params.esf_reach) * params.esf_per_unit).max(0.0).min(params.esf_segments as f32);
    let segment = (place as u32).min(params.esf_segments - 1);
    let t = place - segment as f32;
    let c = esf[(table * params.esf_segments + segment) as usize];
    c[0] + t * (c[1] + t * (c[2] + t * c[3]))
}

/// Share of the light of a pixel past an edge that is no straight line: read from the edge's own profile down the column,
/// which lies behind the tables, four rows a vector.
#[inline(always)]
fn profile(job: &Job<'_>, edge: &Edge, row: i32) -> f32 {
    let i = row - edge.whole;
    if i < 0 || i >= edge.blend as i32 {
        return f32::from(u8::from((i < 0) == (edge.across < 0.0)));
    }
    let at = ((edge.table & !PROFILE) as usize + i as usize) - 4 * job.esf.segments.len();
    job.profiles[at >> 2][at & 3]
}

/// Share of the light that a pixel gets past one edge, integrated over the pixel's area.
#[inline(always)]
pub(crate) fn transmitted(job: &Job<'_>, edge: &Edge, row: i32) -> f32 {
    if edge.table >= PROFILE {
        return profile(job, edge, row);
    }
    let centre = ((row - edge.whole) as f32 - edge.part) * edge.across;
    let mut sum = 0.0;
    for node in &job.quadrature {
        let u = (centre + node.down * edge.across) + node.along * edge.along;
        let mut light = edge_spread(&job.params, &job.esf.segments, u, edge.table);
        if job.stacked {
            light += edge.blend * (edge_spread(&job.params, &job.esf.segments, u, edge.table + 1) - light);
        }
        sum += node.weight * light;
    }
    sum
}

/// Light over the field: vignetting times the backlight's gradient, 1 on the axis.
#[inline(always)]
fn field_light(params: &Params, row: u32, column: u32) -> f32 {
    let u = (column as f32 - params.axis[0]) * params.half_diagonals;
    let v = (row as f32 - params.axis[1]) * params.half_diagonals;
    let r2 = u * u + v * v;
    let lens = 1.0 - r2 * (params.field[0] + r2 * params.field[1]);
    lens * (1.0 + params.field[2] * u + params.field[3] * v - params.sag * r2)
}

/// How counts become pixels of a container.
pub trait Pixel: Copy + Send + Sync + Default {
    /// One pixel from unquantised counts.
    fn from_counts(params: &Params, counts: f32) -> Self;
}

impl Pixel for u8 {
    #[inline(always)]
    fn from_counts(params: &Params, counts: f32) -> Self {
        quantise(params, counts) as u8
    }
}

impl Pixel for u16 {
    #[inline(always)]
    fn from_counts(params: &Params, counts: f32) -> Self {
        quantise(params, counts) as u16
    }
}

impl Pixel for f32 {
    #[inline(always)]
    fn from_counts(params: &Params, counts: f32) -> Self {
        counts.min(params.ceiling)
    }
}

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
    let (bright, shadow) = (params.flat_bright, params.flat_shadow);
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
    let key = row_key(params.pattern_key, sensor_row(params, at.row as u32));
    for i in 0..N {
        let column = (params.column0 + at.column as u32).wrapping_add(i as u32);
        counts[i] += fixed_pattern(params, means[i], key, column);
    }
}

/// Mean grey values of a block of flat pixels.
#[inline(always)]
fn flat_means(job: &Job<'_>, place: Place<'_>, row: i32, factors: &[f32; BLOCK], means: &mut [f32; BLOCK]) {
    let params = &job.params;
    match place.extent.even(row) {
        Some(false) => means.fill(params.shadow),
        Some(true) => {
            for i in 0..BLOCK {
                means[i] = params.shadow + params.contrast * factors[i];
            }
        }
        None => {
            let lanes = means.chunks_exact_mut(CELL).zip(factors.chunks_exact(CELL));
            for ((means, factors), cells) in lanes.zip(place.cells) {
                let inside = between(cells, row);
                for i in 0..CELL {
                    means[i] = params.shadow + if inside[i] { 0.0 } else { params.contrast * factors[i] };
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
        *factor = field_light(params, row, (params.column0 + at.column as u32).wrapping_add(i as u32));
    }
    let Some(map) = job.contamination.as_ref().filter(|_| params.light > 1) else { return };
    clear_light(job, map, at, &mut factors[..count]);
}

/// Multiplies by what contamination leaves of the light; cells that nothing touches are passed over.
#[inline(always)]
fn clear_light(job: &Job<'_>, map: &LightMap, at: At, factors: &mut [f32]) {
    let (row, count) = (at.row as usize, factors.len());
    let first = row * job.params.light_words as usize + at.column / 2;
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

/// Counts of neighbouring pixels, each of a mean of its own.
#[inline(always)]
fn pixels<const N: usize>(job: &Job<'_>, at: At, means: &[f32; N], z: &[f32; N], counts: &mut [f32; N]) {
    for i in 0..N {
        counts[i] = sample(shaped(&job.params, means[i]), z[i]);
    }
    if job.params.pattern != 0 {
        pattern_pixels(&job.params, at, means, counts);
    }
}

/// Counts of a block of a row, far from the edges.
#[inline(always)]
fn fill_block(job: &Job<'_>, place: Place<'_>, at: At, z: &[f32; BLOCK], counts: &mut [f32; BLOCK]) {
    let params = &job.params;
    let even = place.extent.even(at.row);
    if params.light != 0 && even != Some(false) {
        let (mut factors, mut means) = ([1.0; BLOCK], [params.shadow; BLOCK]);
        field_factors(job, at, &mut factors);
        flat_means(job, place, at.row, &factors, &mut means);
        return pixels(job, at, &means, z, counts);
    }
    match even {
        Some(lit) => even_pixels(if lit { params.flat_bright } else { params.flat_shadow }, z, counts),
        None => flat_pixels(params, place.cells, at.row, z, counts),
    }
    if params.pattern != 0 {
        let mut means = [params.shadow; BLOCK];
        flat_means(job, place, at.row, &[1.0; BLOCK], &mut means);
        pattern_pixels(params, at, &means, counts);
    }
}

/// Overwrites the counts of a cell's pixels that one of its edges touches; the other edge adds light only where the two bands
/// overlap.
#[inline(always)]
fn edge_pixels(
    job: &Job<'_>,
    cells: &[EdgeCell; 2],
    side: usize,
    at: At,
    z: &[f32; CELL],
    counts: &mut [f32; CELL],
) {
    let params = &job.params;
    let (mut light, mut means, mut near) = ([0.0; CELL], [0.0; CELL], [0.0; CELL]);
    cells[side].light(job, (at.column, side), at.row, &mut light);
    if params.overlap != 0 {
        let mut other = [0.0; CELL];
        cells[1 - side].light(job, (at.column, 1 - side), at.row, &mut other);
        for i in 0..CELL {
            light[i] += other[i];
        }
    }
    if params.light != 0 {
        let mut factors = [1.0; CELL];
        field_factors(job, at, &mut factors);
        for i in 0..CELL {
            light[i] *= factors[i];
        }
    }
    for i in 0..CELL {
        means[i] = params.shadow + params.contrast * light[i];
    }
    pixels(job, at, &means, z, &mut near);
    for i in 0..CELL {
        if cells[side].in_band(i, at.row, params.band_rows) {
            counts[i] = near[i];
        }
    }
}

/// A place in the frame.
#[derive(Clone, Copy)]
struct At {
    row: i32,
    column: usize,
}

/// A block's edges.
#[derive(Clone, Copy)]
struct Place<'a> {
    extent: &'a BlockExtent,
    cells: &'a [[EdgeCell; 2]],
}

/// Where the edges of a block of columns lie: rows outside `clear` may hold an edge.
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

    /// Whether the whole block lies in the light (`true`) or in the shadow in this row, where it does either.
    fn even(&self, row: i32) -> Option<bool> {
        if row <= self.top.0 || row >= self.bottom.1 {
            return Some(true);
        }
        (row > self.top.1 && row < self.bottom.0).then_some(false)
    }
}

/// What the blocks of a frame share over its rows.
struct Blocks {
    extents: Vec<BlockExtent>,
    cells: Vec<[EdgeCell; 2]>,
}

/// Renders a frame into `out`, row-major, `rows * columns` pixels, on the current thread pool.
pub fn render<P: Pixel>(job: &Job<'_>, out: &mut [P]) {
    let columns = job.params.columns as usize;
    let extents = (0..columns).step_by(BLOCK).map(|first| BlockExtent::new(job, first)).collect();
    let blocks = Blocks { extents, cells: edge_cells(job) };
    out.par_chunks_mut(columns * TASK_ROWS).enumerate().for_each(|(task, rows)| {
        fill_rows(job, &blocks, task * TASK_ROWS, rows);
    });
}

/// Rows `first..` of a frame, in the widest instruction set the machine has.
#[multiversion(
    targets("x86_64+avx2+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2", "aarch64+neon"),
    dispatcher = "direct"
)]
fn fill_rows<P: Pixel>(job: &Job<'_>, blocks: &Blocks, first: usize, out: &mut [P]) {
    let columns = job.params.columns as usize;
    let (mut counts, mut z) = ([0.0f32; BLOCK], [0.0f32; BLOCK]);
    for (r, line) in out.chunks_exact_mut(columns).enumerate() {
        let row = (first + r) as i32;
        let key = row_key(job.params.noise_key, sensor_row(&job.params, row as u32));
        for (block, pixels) in line.chunks_mut(BLOCK).enumerate() {
            let at = At { row, column: block * BLOCK };
            let cells = &blocks.cells[at.column / CELL..];
            let place =
                Place { extent: &blocks.extents[block], cells: &cells[..cells.len().min(BLOCK / CELL)] };
            deviates(key, job.params.column0 + at.column as u32, &mut z);
            fill_block(job, place, at, &z, &mut counts);
            fill_edges(job, place.cells, at, &z, &mut counts);
            for (pixel, c) in pixels.iter_mut().zip(&counts) {
                *pixel = P::from_counts(&job.params, *c);
            }
        }
    }
}

/// Overwrites the pixels of a block of a row that an edge touches.
#[inline(always)]
fn fill_edges(job: &Job<'_>, cells: &[[EdgeCell; 2]], at: At, z: &[f32; BLOCK], counts: &mut [f32; BLOCK]) {
    let (z, _) = z.as_chunks::<CELL>();
    let (counts, _) = counts.as_chunks_mut::<CELL>();
    for (i, ((cells, z), counts)) in cells.iter().zip(z).zip(counts).enumerate() {
        // What both sides share is moved before their loop: it must not be worked out where no edge is.
        if !cells.iter().any(|c| c.touches(at.row)) {
            continue;
        }
        for side in 0..2 {
            if cells[side].touches(at.row) {
                let at = At { column: at.column + i * CELL, ..at };
                edge_pixels(job, cells, side, at, z, counts);
            }
        }
    }
}

/// Writes one value into every pixel: the write floor.
pub fn constant<P: Pixel>(job: &Job<'_>, out: &mut [P]) {
    let value = P::from_counts(&job.params, job.params.words as f32);
    let columns = job.params.columns as usize;
    out.par_chunks_mut(columns * TASK_ROWS).for_each(|rows| rows.fill(value));
}
