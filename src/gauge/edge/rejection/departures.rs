//! How far the middles of both edges depart from an axis, column by column and in blocks of
//! sixteen.

use nalgebra::Vector3;

use crate::gauge::edges::Edge;
use crate::gauge::limit::limits;
use crate::numerics::median_network::{BLOCK, LANES, medians};
use crate::numerics::robust::{MEDIAN_TO_SD, upper_median};

limits! {
    /// When a column or a block departs from the axis.
    DepartureLimits = "departures";
    /// Departure of a column that is refused, in robust standard deviations: noise gives it in
    /// 4·10⁻⁸ of the columns, one frame of 2400 in ten thousand.
    column: f64 = 5.5;
    /// Departure of a block's mean that is refused, in robust standard deviations: noise gives it
    /// in 6·10⁻⁵ of the blocks, where `floor_px` is no larger.
    block: f64 = 4.0;
    /// Departures below this are not tested, px: they change a diameter by twice as much, well
    /// within the scatter of a station.
    floor_px: f64 = 0.04;
    /// Departure to the same side, in standard deviations of a column, beyond which neighbours join
    /// a refused stretch: noise gives it in 7 % of the columns.
    grow: f64 = 1.5;
    /// Columns by which a stretch grows at most: four blocks. A longer one is found by its blocks.
    growth: usize = 64;
    /// Neighbouring columns that are refused with a stretch: the base of a flank too gentle to be
    /// detected. Tuned: see study limits.
    guard: usize = 6;
    /// Share of the blocks that must agree with the axis: the median of their departures gives
    /// their scatter. A smaller share would find axes among films that cover most of a field, and
    /// bends in clean texture.
    agreeing: f64 = 0.5;
    /// Bumps that are left out together when the scatter elsewhere is estimated: the two largest
    /// may hide the third. More would leave few places elsewhere.
    bumps: usize = 3;
}

/// Standard deviation of a block's median over that of a column: √(π/2)/√16, of sixteen normal
/// values.
pub(super) const MEDIAN_OF_BLOCK: f64 = 0.3133;

/// Sixteen columns.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    /// Its place among the frame's blocks.
    pub(super) index: usize,
    /// Abscissa, −1 to 1 over the field.
    pub(super) x: f64,
    /// Median of the middles of both edges, px.
    pub(super) middle: f64,
    /// Median of the widths, px; NaN until they are measured.
    pub(super) width: f64,
}

/// Adjoining blocks that depart from their neighbourhood.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalBump {
    /// By how much the highest stands out, px of the middle.
    pub(super) peak: f64,
    /// First and last block.
    pub(super) first: usize,
    pub(super) last: usize,
    /// Where the neighbourhood lies: 0 on both sides, else before (-1) or behind (1).
    pub(super) step: isize,
}

/// Buffers of [`super::one_sided`], reused from frame to frame. `departures`, `widths` and
/// `refused` have one entry a column and are arrays apart: medians and extremes of sixteen
/// departures are computed in lanes, and widths are read of frames that are not calm alone.
#[derive(Clone, Debug, Default)]
pub(crate) struct AxisScratch {
    /// Middle of every column, NaN without both edges; then its departure from the axis.
    pub(super) departures: Vec<f32>,
    /// Width of every column, NaN without both edges.
    pub(super) widths: Vec<f32>,
    pub(super) blocks: Vec<Block>,
    pub(super) pool: Vec<f32>,
    pub(super) sizes: Vec<f64>,
    /// Columns refused.
    pub(super) refused: Vec<bool>,
    pub(super) ends: Vec<isize>,
    pub(super) suspects: Vec<LocalBump>,
}

impl Block {
    pub(super) fn point(&self) -> (f64, f64) {
        (self.x, self.middle)
    }
}

/// Root mean square standard uncertainty of the middle over some columns, from the own
/// uncertainties of both edges, px.
pub(super) fn own_noise((top, bottom): (&[Edge], &[Edge]), columns: std::ops::Range<usize>) -> f64 {
    let own = |edge: &Edge| f64::from(edge.u_own_px).powi(2);
    let pairs = top[columns.clone()].iter().zip(&bottom[columns]);
    let usable = pairs.filter(|(t, b)| t.is_usable() && b.is_usable());
    let (sum, count) = usable.fold((0.0, 0.0_f64), |(sum, n), (t, b)| (sum + own(t) + own(b), n + 1.0));
    (0.25 * sum / count.max(1.0)).sqrt()
}

/// Medians of eight whole blocks; `None` where a value is missing.
fn whole_medians(chunk: &[f32]) -> Option<[f32; LANES]> {
    let blocks = chunk.as_chunks::<BLOCK>().0.first_chunk::<LANES>()?;
    if !chunk.iter().fold(true, |all, value| all & value.is_finite()) {
        return None;
    }
    let mut turned = [[0.0; LANES]; BLOCK];
    for (lane, block) in blocks.iter().enumerate() {
        for (row, value) in turned.iter_mut().zip(block) {
            row[lane] = *value;
        }
    }
    Some(medians(&mut turned))
}

/// Robust standard deviation: the `agreeing` quantile of absolute departures over that of a
/// normal distribution.
pub(super) fn robust_sd(sizes: &mut [f64]) -> f64 {
    let index = (DepartureLimits::get().agreeing * sizes.len() as f64) as usize;
    let index = index.min(sizes.len().saturating_sub(1));
    MEDIAN_TO_SD * *sizes.select_nth_unstable_by(index, f64::total_cmp).1
}

fn abscissa(column: f64, columns: usize) -> f64 {
    2.0 * column / columns.max(1) as f64 - 1.0
}

pub(super) fn basis(x: f64) -> Vector3<f64> {
    Vector3::new(1.0, x, x * x)
}

/// Median and number of the finite values; `None` where there are none.
fn median(values: &[f32], pool: &mut Vec<f32>) -> Option<(f32, usize)> {
    pool.clear();
    pool.extend(values.iter().filter(|m| m.is_finite()));
    let count = pool.len();
    upper_median(pool, f32::total_cmp).map(|median| (median, count))
}

impl AxisScratch {
    /// Reserves buffers for frames of so many columns.
    pub(crate) fn reserve(&mut self, columns: usize) {
        fn room<T>(values: &mut Vec<T>, length: usize) {
            values.reserve(length.saturating_sub(values.len()));
        }
        room(&mut self.departures, columns);
        room(&mut self.widths, columns);
        room(&mut self.refused, columns);
        room(&mut self.ends, columns);
        room(&mut self.blocks, columns / BLOCK + 1);
        room(&mut self.sizes, columns / BLOCK + 257);
        room(&mut self.pool, BLOCK);
        room(&mut self.suspects, DepartureLimits::get().bumps);
    }

    /// Standard deviation of the median of a block by the own noise of its edges, with so many
    /// usable columns in the frame, px.
    pub(super) fn block_noise(&self, edges: (&[Edge], &[Edge]), usable: usize) -> f64 {
        let columns = usable as f64 / self.blocks.len().max(1) as f64;
        own_noise(edges, 0..edges.0.len()) * (0.5 * std::f64::consts::PI / columns.max(1.0)).sqrt()
    }

    /// Middles of the columns and medians of the blocks; returns the number of columns with both
    /// edges.
    pub(super) fn middles(&mut self, top: &[Edge], bottom: &[Edge]) -> usize {
        let columns = top.len();
        self.departures.clear();
        self.widths.clear();
        self.blocks.clear();
        // Rows relative to the first, so that f32 keeps 1e-5 px.
        let origin = top.iter().zip(bottom).find(|(t, b)| t.is_usable() && b.is_usable());
        let origin = origin.map_or(0.0, |(t, b)| 0.5 * (t.row_px + b.row_px));
        self.departures.extend(top.iter().zip(bottom).map(|(t, b)| {
            let both = t.is_usable() && b.is_usable();
            if both { (0.5 * (t.row_px + b.row_px) - origin) as f32 } else { f32::NAN }
        }));
        let mut usable = 0;
        let block = |index: usize, length: usize, middle: f32| Block {
            index,
            x: abscissa((index * BLOCK + length / 2) as f64, columns),
            middle: f64::from(middle),
            width: f64::NAN,
        };
        for (group, chunk) in self.departures.chunks(LANES * BLOCK).enumerate() {
            let first = group * LANES;
            if let Some(medians) = whole_medians(chunk) {
                usable += chunk.len();
                self.blocks.extend((first..).zip(medians).map(|(index, m)| block(index, BLOCK, m)));
                continue;
            }
            for (index, chunk) in (first..).zip(chunk.chunks(BLOCK)) {
                let Some((middle, count)) = median(chunk, &mut self.pool) else { continue };
                usable += count;
                if count >= BLOCK / 2 {
                    self.blocks.push(block(index, chunk.len(), middle));
                }
            }
        }
        usable
    }

    /// Widths of the columns and of the blocks relative to the first one, px; once a frame, and
    /// only where it is not calm.
    pub(super) fn measure_widths(&mut self, top: &[Edge], bottom: &[Edge]) {
        if !self.widths.is_empty() {
            return;
        }
        let first = top.iter().zip(bottom).find(|(t, b)| t.is_usable() && b.is_usable());
        let origin = first.map_or(0.0, |(t, b)| b.row_px - t.row_px);
        self.widths.extend(top.iter().zip(bottom).map(|(t, b)| {
            let both = t.is_usable() && b.is_usable();
            if both { (b.row_px - t.row_px - origin) as f32 } else { f32::NAN }
        }));
        for block in &mut self.blocks {
            let from = block.index * BLOCK;
            let widths = &self.widths[from..(from + BLOCK).min(top.len())];
            block.width = median(widths, &mut self.pool).map_or(f64::NAN, |(width, _)| f64::from(width));
        }
    }

    /// Robust standard deviation of the blocks about an axis, px.
    pub(super) fn spread(&mut self, axis: &Vector3<f64>) -> f64 {
        self.sizes.clear();
        self.sizes.extend(self.blocks.iter().map(|b| (b.middle - axis.dot(&basis(b.x))).abs()));
        robust_sd(&mut self.sizes)
    }

    /// Subtracts the axis from the middles; returns the robust standard deviations of a column and
    /// of a block, px.
    pub(super) fn depart(&mut self, axis: &Vector3<f64>, columns: usize) -> (f64, f64) {
        let scale = 2.0 / columns.max(1) as f64;
        for (column, departure) in self.departures.iter_mut().enumerate() {
            let x = column as f64 * scale - 1.0;
            *departure -= (axis[0] + x * (axis[1] + x * axis[2])) as f32;
        }
        let block_sd = self.spread(axis);
        self.sizes.clear();
        let step = columns.div_ceil(256).max(1);
        let every = self.departures.iter().step_by(step);
        self.sizes.extend(every.filter(|d| d.is_finite()).map(|d| f64::from(d.abs())));
        let column_sd = if self.sizes.is_empty() { 0.0 } else { robust_sd(&mut self.sizes) };
        // The scatter of a few blocks may be small by chance, but hardly smaller than that of their
        // columns implies.
        (column_sd, block_sd.max(column_sd * MEDIAN_OF_BLOCK))
    }

    /// Marks departures and the columns that belong to them; returns whether there are any. Where
    /// illumination falls off along the shaft, edges in its dim part scatter by more than the mean
    /// of the field: a departure within their own noise is none.
    pub(super) fn mark(&mut self, (column_sd, block_sd): (f64, f64), edges: (&[Edge], &[Edge])) -> bool {
        let limits = DepartureLimits::get();
        let columns = self.departures.len();
        let column_limit = (limits.column * column_sd).max(2.0 * limits.floor_px) as f32;
        let block_limit = (limits.block * block_sd).max(limits.floor_px) as f32;
        let grow = (limits.grow * column_sd).max(0.5 * limits.floor_px) as f32;
        self.refused.clear();
        self.refused.resize(columns, false);
        let mut any = false;
        for (index, chunk) in self.departures.chunks(BLOCK).enumerate() {
            let (mut sum, mut count, mut least, mut most) = (0.0_f32, 0.0_f32, 0.0_f32, 0.0_f32);
            for d in chunk.iter().filter(|d| d.is_finite()) {
                (sum, count) = (sum + d, count + 1.0);
                (least, most) = (least.min(*d), most.max(*d));
            }
            let whole = sum.abs() > block_limit * count && count >= 4.0;
            if !whole && most.max(-least) <= column_limit {
                continue;
            }
            let place = index * BLOCK..index * BLOCK + chunk.len();
            let own = own_noise(edges, place.clone()) as f32;
            if whole && sum.abs() > limits.block as f32 * own * count.sqrt() {
                self.refused[place].fill(true);
                any = true;
                continue;
            }
            let limit = column_limit.max(limits.column as f32 * own);
            for (refused, d) in self.refused[place].iter_mut().zip(chunk) {
                *refused |= d.abs() > limit;
                any |= *refused;
            }
        }
        if any {
            self.grow(grow);
        }
        any
    }

    /// Columns refused that had both edges.
    pub(super) fn refused_columns(&self) -> usize {
        self.refused.iter().zip(&self.departures).filter(|(r, d)| **r && d.is_finite()).count()
    }

    /// Extends refused stretches over neighbouring columns that depart to the same side, and by a
    /// guard beyond.
    pub(super) fn grow(&mut self, limit: f32) {
        let limits = DepartureLimits::get();
        let columns = self.departures.len() as isize;
        let refused = &self.refused;
        let open = |n: isize| n >= 0 && n < columns && !refused[n as usize];
        self.ends.clear();
        self.ends.extend((0..columns).filter(|c| refused[*c as usize] && (open(c - 1) || open(c + 1))));
        for index in 0..self.ends.len() {
            let seed = self.ends[index];
            let sign = self.departures[seed as usize].signum();
            for step in [-1_isize, 1] {
                let (mut at, mut quiet, mut last) = (seed, 0, seed);
                while quiet < 4 && (at - seed).unsigned_abs() < limits.growth {
                    at += step;
                    if at < 0 || at >= columns {
                        break;
                    }
                    let d = self.departures[at as usize] * sign;
                    if d > limit || !d.is_finite() {
                        (quiet, last) = (0, at);
                    } else {
                        quiet += 1;
                    }
                }
                let reach = (last + step * limits.guard as isize).clamp(0, columns - 1);
                let (a, b) = (seed.min(reach) as usize, seed.max(reach) as usize);
                self.refused[a..=b].fill(true);
            }
        }
    }
}
