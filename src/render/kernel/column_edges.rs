//! From the silhouette to the kernel's input for every column.
//!
//! A pixel averages the edge over its own area and the blur, K = box ∗ g_σ along the row. To second
//! order a curved or rough edge e(x) is equivalent to a straight one at the K-weighted mean of e,
//! widened by the K-weighted variance about the tangent: for a straight edge that is σ²/cos²β +
//! (1 + tan²β)/12 in rows, exactly. The truth is e itself.
//!
//! Positions go to the kernel as integer + fraction: f32 rows would lose 1e-4 px above row 2048.

use multiversion::multiversion;
use rayon::prelude::*;

use crate::render::optics::esf_table::EsfTable;

/// Columns of a task; the result does not depend on the number of threads.
const BLOCK: usize = 256;

/// Both edges of a column in pixels of the frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ColumnEdges {
    /// Row of the upper edge.
    pub top_px: f64,
    /// Row of the lower edge.
    pub bottom_px: f64,
}

/// One edge of one column for the kernel: u = sign·(((row - whole) - part)·across), plus the share
/// of its slope.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Edge {
    /// Integer part of the edge's row.
    pub whole: i32,
    /// The rest, -1/2..1/2.
    pub part: f32,
    /// -cos β / scale for an upper edge, +cos β / scale for a lower one: units of the table per
    /// row.
    pub across: f32,
    /// ±sin β / scale with the opposite sign: units of the table per column.
    pub along: f32,
    /// Edge-spread table; from [`PROFILE`] on the index of the edge's own profile, counted in f32
    /// from the first table.
    pub table: u32,
    /// Share of the next table; of a profile its rows, the first of which is `whole`.
    pub blend: f32,
}

/// Marks an edge with a profile of its own, because it is not straight within the blur.
pub(crate) const PROFILE: u32 = 0x8000_0000;

/// Both edges of a column for the kernel.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Column {
    /// Light above it.
    pub top: Edge,
    /// Light below it.
    pub bottom: Edge,
}

/// The weights K over neighbouring columns.
#[derive(Clone, Debug)]
pub(crate) struct RowBlur {
    weights: Vec<f64>,
    /// Σ w i², the discrete variance.
    variance: f64,
}

/// Straight-edge equivalent of an edge about a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Straight {
    pub(crate) row: f64,
    pub(crate) slope: f64,
    pub(crate) excess_variance: f64,
}

impl RowBlur {
    /// K for a blur of `scale_px`.
    pub(crate) fn new(scale_px: f64) -> Self {
        let variance = scale_px * scale_px + 1.0 / 12.0;
        let reach = (4.0 * variance.sqrt()).ceil() as i64;
        let raw: Vec<f64> = (-reach..=reach).map(|i| (-0.5 * (i * i) as f64 / variance).exp()).collect();
        let sum: f64 = raw.iter().sum();
        let weights: Vec<f64> = raw.iter().map(|w| w / sum).collect();
        let variance = weights.iter().zip(-reach..=reach).map(|(w, i)| w * (i * i) as f64).sum();
        Self { weights, variance }
    }

    /// Columns needed beyond either end of the frame.
    pub(crate) fn reach(&self) -> usize {
        self.weights.len() / 2
    }

    /// The straight equivalent of `edges`, the window of `2·reach + 1` rows about a column.
    pub(crate) fn straight(&self, edges: impl Iterator<Item = f64> + Clone) -> Straight {
        let reach = self.reach() as f64;
        let row: f64 = self.weights.iter().zip(edges.clone()).map(|(w, e)| w * e).sum();
        let (mut moment, mut variance) = (0.0, 0.0);
        for ((i, w), e) in self.weights.iter().enumerate().zip(edges) {
            let departure = e - row;
            moment += w * (i as f64 - reach) * departure;
            variance += w * departure * departure;
        }
        self.equivalent(row, moment, variance)
    }

    fn equivalent(&self, row: f64, moment: f64, variance: f64) -> Straight {
        let slope = moment / self.variance;
        Straight { row, slope, excess_variance: (variance - slope * slope * self.variance).max(0.0) }
    }
}

/// [`RowBlur::straight`] of neighbouring columns, one per lane: the same sums in the same order.
struct Straights {
    row: [f64; BLOCK],
    moment: [f64; BLOCK],
    variance: [f64; BLOCK],
}

/// `rows` holds the edge over the block's columns and `blur`'s reach to either side.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"), dispatcher = "direct")]
fn straights(blur: &RowBlur, rows: &[f64], out: &mut Straights) {
    let count = rows.len() - 2 * blur.reach();
    let reach = blur.reach() as f64;
    let (row, moment, variance) =
        (&mut out.row[..count], &mut out.moment[..count], &mut out.variance[..count]);
    row.fill(0.0);
    moment.fill(0.0);
    variance.fill(0.0);
    for (i, w) in blur.weights.iter().enumerate() {
        for (row, e) in row.iter_mut().zip(&rows[i..i + count]) {
            *row += w * e;
        }
    }
    for (i, w) in blur.weights.iter().enumerate() {
        let lever = w * (i as f64 - reach);
        let lanes = moment.iter_mut().zip(&mut *variance).zip(&*row).zip(&rows[i..i + count]);
        for (((moment, variance), row), e) in lanes {
            let departure = e - row;
            *moment += lever * departure;
            *variance += w * departure * departure;
        }
    }
}

/// Depth of the axis and radius of the surface in a column.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Depth {
    /// Distance of the axis from best focus at the upper and at the lower edge, mm towards the
    /// camera.
    pub y_mm: [f64; 2],
    /// Mean radius, mm.
    pub radius_mm: f64,
}

/// Kernel columns of `edges`, which reach [`RowBlur::reach`] columns beyond the frame at either
/// end; `depth` of every column, or empty where all are in focus.
pub(crate) fn kernel_columns(
    edges: &[ColumnEdges],
    depth: &[Depth],
    blur: &RowBlur,
    esf: &EsfTable,
) -> Vec<Column> {
    let count = edges.len().saturating_sub(2 * blur.reach());
    let mut columns: Vec<Column> = vec![bytemuck::Zeroable::zeroed(); count];
    columns.par_chunks_mut(BLOCK).enumerate().for_each(|(block, columns)| {
        let first = block * BLOCK;
        let window = &edges[first..first + columns.len() + 2 * blur.reach()];
        for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let rows: Vec<f64> =
                window.iter().map(|e| if side == 0 { e.top_px } else { e.bottom_px }).collect();
            let zeros = [0.0; BLOCK];
            let mut found = Straights { row: zeros, moment: zeros, variance: zeros };
            straights(blur, &rows, &mut found);
            for (i, column) in columns.iter_mut().enumerate() {
                let straight = blur.equivalent(found.row[i], found.moment[i], found.variance[i]);
                let depth = depth.get(first + i).copied().unwrap_or_default();
                let e = edge(straight, (depth.y_mm[side], depth.radius_mm), esf, sign);
                if side == 0 {
                    column.top = e;
                } else {
                    column.bottom = e;
                }
            }
        }
    });
    columns
}

fn edge(straight: Straight, (y_mm, radius_mm): (f64, f64), esf: &EsfTable, sign: f64) -> Edge {
    let cos = 1.0 / straight.slope.hypot(1.0);
    let place = esf.place(y_mm, radius_mm, straight.excess_variance * cos * cos);
    let scale = place.scale_px;
    let whole = straight.row.round();
    Edge {
        whole: whole as i32,
        part: (straight.row - whole) as f32,
        across: (sign * cos / scale) as f32,
        along: (-sign * cos * straight.slope / scale) as f32,
        table: place.table,
        blend: place.blend as f32,
    }
}

/// Largest |sin β| over all columns.
pub(crate) fn steepest(columns: &[Column]) -> f64 {
    let tan = columns.iter().flat_map(|c| [c.top, c.bottom]).map(|e| f64::from((e.along / e.across).abs()));
    let tan = tan.fold(0.0, f64::max);
    tan / tan.hypot(1.0)
}

/// Largest error of the light where the pixel's square is convolved into the table, share of full
/// intensity.
const FOLDED_ERROR: f64 = 1e-6;

/// Largest |sin β| for which it is convolved.
const FOLDED_SIN: f64 = 0.1;

/// The table convolved with the pixel, where the slopes and the variation of the blur are small
/// enough for an error below 1e-6; adapts the edges' scales to it.
///
/// The square has the variance 1/12 across an edge of any slope. Its fourth cumulant is -(cos⁴β +
/// sin⁴β)/120 where the table has -1/120: with |F⁗| ≤ .55/σ⁴ the light errs by .55 sin²β/(1440 σ⁴).
/// An edge of another blur s than the table's σ is given the scale of the same variance, (s² +
/// 1/12)/(σ² + 1/12), whose box is too wide: .55·2(s² - σ²)/(2880 σ⁶).
pub(crate) fn fold_pixel<'a>(esf: &'a EsfTable, columns: &mut [Column]) -> Option<&'a EsfTable> {
    let s0 = esf.scale_px;
    let sharp = esf.sharp_px;
    let most_sin = (FOLDED_ERROR * 1440.0 / 0.55).sqrt() * sharp * sharp;
    let most_widening = FOLDED_ERROR * 2880.0 / 1.1 * sharp.powi(6);
    let excess = |e: &Edge| 1.0 / (f64::from(e.across).powi(2) + f64::from(e.along).powi(2)) - s0 * s0;
    let fits = |e: &Edge| {
        let v = excess(e);
        if esf.widens { v <= most_widening } else { v.abs() <= 2e-5 * s0 * s0 }
    };
    let level = steepest(columns) <= most_sin.min(FOLDED_SIN);
    if !level || !columns.iter().all(|c| fits(&c.top) && fits(&c.bottom)) {
        return None;
    }
    let folded = esf.over_pixel()?;
    for e in columns.iter_mut().flat_map(|c| [&mut c.top, &mut c.bottom]) {
        let v = excess(e);
        // f32 is accurate to 1e-7.
        if v > 1e-6 * s0 * s0 {
            let scale = s0 * (1.0 + v / (s0 * s0 + 1.0 / 12.0)).sqrt();
            let factor = (s0 * s0 + v).sqrt() / scale;
            e.across = (f64::from(e.across) * factor) as f32;
            e.along = (f64::from(e.along) * factor) as f32;
        }
    }
    Some(folded)
}

/// Rows that the edges can affect: first rows of both edges per group of `group` columns, and rows
/// of a band.
#[derive(Clone, Debug, PartialEq)]
pub struct Bands {
    /// First row of the upper and the lower band of every group, in rows of the frame (may be
    /// negative).
    pub start: Vec<[i32; 2]>,
    /// Rows of every band.
    pub rows: u32,
    /// Whether an upper and a lower band share rows: a pixel there is affected by both edges.
    pub overlap: bool,
    /// Rows between the bands, in the shadow over all columns.
    pub dark: std::ops::Range<i32>,
}

/// First and last row that an edge affects.
fn rows_of(e: &Edge, esf: &EsfTable) -> (i32, i32) {
    if e.table >= PROFILE {
        return (e.whole, e.whole + (e.blend as i32 - 1).max(0));
    }
    let pixel = if esf.over_pixel { 0.0 } else { 1.0 };
    let half = (esf.reach / e.across.abs() + 0.5 * (pixel + (e.along / e.across).abs())).ceil() as i32;
    (e.whole - half, e.whole + half)
}

/// Bands that contain every pixel with neither full light nor full shadow.
pub(crate) fn bands(columns: &[Column], group: usize, esf: &EsfTable) -> Bands {
    let parts: Vec<(i32, Vec<[i32; 2]>)> = columns
        .par_chunks(group * BLOCK)
        .map(|columns| {
            let mut rows = 1;
            let one = |members: &[Column]| {
                let (first, last) = touched(members, esf);
                rows = rows.max((0..2).map(|s| last[s] - first[s] + 1).max().unwrap_or(1));
                first
            };
            let start = columns.chunks(group).map(one).collect();
            (rows, start)
        })
        .collect();
    let rows = parts.iter().map(|p| p.0).max().unwrap_or(1);
    let start: Vec<[i32; 2]> = parts.into_iter().flat_map(|p| p.1).collect();
    let overlap = start.iter().any(|[upper, lower]| lower.saturating_sub(*upper) < rows);
    let above = start.iter().map(|s| s[0].saturating_add(rows)).max().unwrap_or(0);
    let below = start.iter().map(|s| s[1]).min().unwrap_or(0);
    Bands { start, rows: rows as u32, overlap, dark: above..below.max(above) }
}

/// First and last rows that the upper and the lower edges of some columns affect.
fn touched(members: &[Column], esf: &EsfTable) -> ([i32; 2], [i32; 2]) {
    let (mut first, mut last) = ([i32::MAX; 2], [i32::MIN; 2]);
    for column in members {
        for (side, e) in [column.top, column.bottom].iter().enumerate() {
            let (from, to) = rows_of(e, esf);
            first[side] = first[side].min(from);
            last[side] = last[side].max(to);
        }
    }
    (first, last)
}
