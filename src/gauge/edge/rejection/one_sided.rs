//! One edge that leaves its place while the other one does not: matter on the part, not its form.
//!
//! Steps, tapers and bends of a turned part move both edges of a column alike, so that the middle (top + bottom)/2 follows the axis: over
//! one field a parabola, whatever the profile. Matter that adheres to one side, or a chip that touches it, moves the middle by half of
//! what it adds to the diameter. A shaft that bends more than a parabola shows leaves its widths alone ([`bent`]). The parabola is fitted to medians of sixteen columns, robustly where they disagree; the scatter about it
//! (noise, texture, vibration) is the yardstick, so that a part whose middle wanders by itself is not refused.

mod bent;
mod bump_extent;
mod local_bumps;

use crate::numerics::robust::MEDIAN_TO_SD;
use nalgebra::{Matrix3, Vector3};

use self::local_bumps::{HILLS, Hill};
use crate::gauge::edges::{Edge, EdgeState};
use crate::numerics::median_network::{BLOCK, LANES, medians};
use crate::profile::Reason;

/// Fewest blocks that tell an axis from an excursion.
const LEAST_BLOCKS: usize = 8;
/// Departures of a column and of a block's mean that are refused, in robust standard deviations of either.
const COLUMN_LIMIT: f64 = 5.5;
const BLOCK_LIMIT: f64 = 4.0;
/// Standard deviation of a block's median over that of a column: √(π/2)/√16.
const MEDIAN_OF_BLOCK: f64 = 0.3133;
/// Departures below this are left alone, px: they move a diameter by twice as much, well inside what a station's scatter says.
const FLOOR_PX: f64 = 0.04;
/// A refused stretch grows over neighbours that depart to the same side by so many standard deviations, this far at most.
const GROW_LIMIT: f64 = 1.5;
const GROWTH: usize = 64;
/// Neighbours of a refused stretch that go with it: the foot of what rises too gently to be told.
const GUARD: usize = 6;
/// Share of the blocks that must agree with the axis: the median of their departures states their scatter.
/// A smaller share would find axes among films that cover most of a field, and bends of clean texture too.
const AGREEING: f64 = 0.5;
/// Trial axes of the robust fit.
const TRIALS: usize = 160;
/// Times that the axis is laid anew through what was not refused.
const PASSES: usize = 3;
/// Bend of an axis that is taken for the part's own, px.
const BEND_OF_WANDER_PX: f64 = 0.03;
/// Departures from the plain parabola up to which no other axis is looked for, px.
const CALM_PX: f64 = 0.05;
/// Share of the plain parabola's spread below which another axis is believed, and bend up to which the parabola may be the part's own.
const BETTER: f64 = 0.35;
const BEND_OF_PART_PX: f64 = 0.3;
/// Widening over twice the departure of the middle that tells matter from an axis that wanders: 1 and 0.
const LEAST_BULGE: f64 = 0.5;
const MOST_BULGE: f64 = 1.6;
/// A stretch bulges where it stands out by so many times what tells it from the axis, and a frame where most of what leaves the axis does.
const PROMINENT: f64 = 1.5;
const BULGING: f64 = 0.75;
/// Share of the columns that matter hides from which a field counts as dirty, and the spread about the axis, px, above which nothing vouches
/// for what is left of a dirty field: among much matter a middle that wanders is matter too, sooner than form.
const DIRTY: f64 = 0.05;
const VOUCHED_PX: f64 = 0.08;
/// Usual bend of the axis over half a field, px (a shaft bent by 0.1 mm on 500 mm bends by 0.03 px on 30 mm). A film as long as the
/// field looks like a bend; a larger one than usual costs a trial its spread times √(1 + (bend/this)²).
const USUAL_BEND_PX: f64 = 0.05;

/// Sixteen columns.
#[derive(Clone, Copy, Debug)]
struct Block {
    /// Its place among the frame's blocks.
    index: usize,
    /// Abscissa, −1 to 1 over the field.
    x: f64,
    /// Median of the middles of both edges, px.
    middle: f64,
    /// Median of the widths, px; NaN until they are measured.
    width: f64,
}

/// Memory of [`refuse_one_sided`].
#[derive(Clone, Debug, Default)]
pub(crate) struct AxisScratch {
    /// Middle of every column, NaN without both edges; then its departure from the axis.
    departures: Vec<f32>,
    /// Width of every column, NaN without both edges.
    widths: Vec<f32>,
    blocks: Vec<Block>,
    pool: Vec<f32>,
    sizes: Vec<f64>,
    refused: Vec<bool>,
    ends: Vec<isize>,
    suspects: Vec<Hill>,
}

/// Refuses the edge of each column that leaves the axis to its side; gives the share of the columns refused.
pub(crate) fn refuse_one_sided(top: &mut [Edge], bottom: &mut [Edge], scratch: &mut AxisScratch) -> f64 {
    let (mut refused, mut dirty) = (0.0, None);
    for _ in 0..PASSES {
        let share = refuse_once(top, bottom, &mut dirty, scratch);
        refused += share * (1.0 - refused);
        if share == 0.0 {
            break;
        }
    }
    refused
}

/// Whether matter hides much of a field.
fn is_dirty(top: &[Edge], bottom: &[Edge]) -> bool {
    let by_matter =
        |e: &Edge| matches!(e.reason(), Some(Reason::Residual | Reason::Contaminated | Reason::Outlier));
    let hidden = top.iter().zip(bottom).filter(|(t, b)| by_matter(t) || by_matter(b)).count();
    hidden as f64 > DIRTY * top.len() as f64
}

/// One pass; `dirty` is found out in the first.
fn refuse_once(
    top: &mut [Edge],
    bottom: &mut [Edge],
    dirty: &mut Option<bool>,
    scratch: &mut AxisScratch,
) -> f64 {
    let usable = scratch.middles(top, bottom);
    if scratch.blocks.len() < LEAST_BLOCKS {
        if usable == 0 || top.len() < 2 * LEAST_BLOCKS * BLOCK {
            return 0.0;
        }
        // Too little of a wide field is left to tell an axis from: nothing vouches for it.
        return refuse_all(top);
    }
    let Some(plain) = scratch.plain() else { return 0.0 };
    let calm = scratch.is_calm(&plain);
    let dirty = *dirty.get_or_insert_with(|| !calm && is_dirty(top, bottom));
    if !calm || usable < top.len() {
        scratch.measure_widths(top, bottom);
    }
    if !calm && bent::is_bent(&scratch.blocks) {
        return 0.0;
    }
    let Some(axis) = (if calm { Some(plain) } else { scratch.axis(plain) }) else { return 0.0 };
    let (column_sd, block_sd) = scratch.depart(&axis, top.len());
    let mut any = scratch.mark((column_sd, block_sd), (&*top, &*bottom));
    if !calm {
        any |= scratch.mark_local(&axis, (column_sd, dirty), (&*top, &*bottom));
    }
    if !any && usable == top.len() {
        return 0.0;
    }
    if !any && dirty && block_sd > VOUCHED_PX {
        return refuse_all(top);
    }
    scratch.measure_widths(top, bottom);
    scratch.descend();
    let refused = scratch.refused_columns();
    for (column, refuse) in scratch.refused.iter().enumerate() {
        if *refuse && top[column].is_usable() && bottom[column].is_usable() {
            let outwards_above = scratch.departures[column] < 0.0;
            let edge = if outwards_above { &mut top[column] } else { &mut bottom[column] };
            edge.state = EdgeState::Gap(Reason::Contaminated);
        }
    }
    refused as f64 / usable.max(1) as f64
}

fn refuse_all(line: &mut [Edge]) -> f64 {
    for edge in line.iter_mut().filter(|e| e.is_usable()) {
        edge.state = EdgeState::Gap(Reason::Contaminated);
    }
    1.0
}

/// Root mean square of the noise that the edges of some columns state of their middle, px.
fn own_noise((top, bottom): (&[Edge], &[Edge]), columns: std::ops::Range<usize>) -> f64 {
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

/// Standard deviation from the agreeing share of departures.
fn robust_sd(sizes: &mut [f64]) -> f64 {
    let index = (AGREEING * sizes.len() as f64) as usize;
    MEDIAN_TO_SD * *sizes.select_nth_unstable_by(index, f64::total_cmp).1
}

fn abscissa(column: f64, columns: usize) -> f64 {
    2.0 * column / columns.max(1) as f64 - 1.0
}

fn basis(x: f64) -> Vector3<f64> {
    Vector3::new(1.0, x, x * x)
}

impl Block {
    fn point(&self) -> (f64, f64) {
        (self.x, self.middle)
    }
}

/// Median and number of the finite values; `None` where there are none.
fn median(values: &[f32], pool: &mut Vec<f32>) -> Option<(f32, usize)> {
    pool.clear();
    pool.extend(values.iter().filter(|m| m.is_finite()));
    let middle = pool.len() / 2;
    let count = pool.len();
    (count > 0).then(|| (*pool.select_nth_unstable_by(middle, f32::total_cmp).1, count))
}

impl AxisScratch {
    /// Makes room for frames of so many columns, whatever they show.
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
        room(&mut self.suspects, HILLS);
    }

    /// Middles of the columns and medians of the blocks; gives the number of columns with both edges.
    fn middles(&mut self, top: &[Edge], bottom: &[Edge]) -> usize {
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

    /// Widths of the columns and of the blocks, px from the first one's; once a frame that is not calm.
    fn measure_widths(&mut self, top: &[Edge], bottom: &[Edge]) {
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

    /// The parabola by least squares.
    fn plain(&self) -> Option<Vector3<f64>> {
        fit(self.blocks.iter().map(Block::point), true)
    }

    /// Whether all blocks agree with a parabola that hardly bends.
    fn is_calm(&self, plain: &Vector3<f64>) -> bool {
        plain[2].abs() < BEND_OF_WANDER_PX && !self.blocks.iter().any(|b| far(plain, CALM_PX, b))
    }

    /// The axis of a frame that is not calm: what half of the blocks agree with best.
    fn axis(&mut self, plain: Vector3<f64>) -> Option<Vector3<f64>> {
        let mut found = self.candidates(&plain)?;
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Matter bulges from the axis, or half of the field agrees with a straighter axis far better; where neither is so, or the rest would
        // be dents, the axis itself wanders.
        let shares = found.map(|(_, axis)| self.bulges(&axis));
        for ((cost, axis), (bulging, _)) in found.iter().zip(shares) {
            if cost.is_finite() && bulging > BULGING {
                return Some(*axis);
            }
        }
        let wanders = found[0].0 > BETTER * self.spread(&plain) && plain[2].abs() < BEND_OF_PART_PX;
        Some(if wanders || shares[0].1 > BULGING { plain } else { found[0].1 })
    }

    /// The best line and the best parabola with what they cost: what two or three blocks say is not yet what all that agree say.
    fn candidates(&mut self, plain: &Vector3<f64>) -> Option<[(f64, Vector3<f64>); 2]> {
        let mut best = [(f64::INFINITY, *plain), (self.cost(plain), *plain)];
        let n = self.blocks.len();
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        let mut draw = |from: usize, to: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            from + ((state >> 33) as usize) % (to - from).max(1)
        };
        for trial in 0..TRIALS {
            // An axis through neighbours says nothing of the rest.
            let mut three = [draw(0, n), draw(0, n), draw(0, n)];
            three.sort_unstable();
            let bent = trial % 2 == 0;
            let apart =
                if bent { (three[1] - three[0]).min(three[2] - three[1]) } else { three[2] - three[0] };
            if apart < n / 6 {
                continue;
            }
            let axis = through(three.map(|k| self.blocks[k].point()), bent);
            let (cost, kept) = &mut best[usize::from(bent)];
            if self.is_cheaper(&axis, *cost) {
                (*cost, *kept) = (self.cost(&axis), axis);
            }
        }
        for (cost, axis) in best.iter_mut().filter(|(cost, _)| cost.is_finite()) {
            *axis = self.refined(*axis)?;
            *cost = cost.min(self.cost(axis));
        }
        Some(best)
    }

    /// An axis by least squares through the blocks that agree with it.
    fn refined(&mut self, mut axis: Vector3<f64>) -> Option<Vector3<f64>> {
        for _ in 0..3 {
            let limit = (3.0 * self.spread(&axis)).max(0.5 * FLOOR_PX);
            let kept = || self.blocks.iter().filter(|b| !far(&axis, limit, b)).map(Block::point);
            let bent = fit(kept(), true)?;
            axis = if bent[2].abs() < USUAL_BEND_PX.max(1.5 * axis[2].abs()) {
                bent
            } else {
                fit(kept(), false)?
            };
        }
        Some(axis)
    }

    /// Which share of what leaves an axis bulges, and which is dents: matter on one side widens the shadow by twice what it moves the
    /// middle by; an axis that wanders moves both edges alike, texture dents as often as it bulges; a chip taken for the part leaves the
    /// part a dent.
    fn bulges(&mut self, axis: &Vector3<f64>) -> (f64, f64) {
        let limit = (3.0 * self.spread(axis)).max(FLOOR_PX);
        let leaves = |b: &Block| far(axis, limit, b);
        let within = self.blocks.iter().filter(|b| !leaves(b));
        let Some(line) = fit(within.map(|b| (b.x, b.width)), false) else { return (0.0, 0.0) };
        let (mut bulging, mut denting, mut all) = (0.0, 0.0, 0.0);
        let (mut from, n) = (0, self.blocks.len());
        while from < n {
            if !leaves(&self.blocks[from]) {
                from += 1;
                continue;
            }
            let to = (from..n).find(|k| !leaves(&self.blocks[*k])).unwrap_or(n);
            let (widening, square) = self.widening(axis, &line, from..to);
            let peak = self.blocks[from..to].iter().any(|b| far(axis, PROMINENT * limit, b));
            all += square;
            if peak && widening > LEAST_BULGE * square && widening < MOST_BULGE * square {
                bulging += square;
            }
            if widening < -LEAST_BULGE * square {
                denting += square;
            }
            from = to;
        }
        if all > 0.0 { (bulging / all, denting / all) } else { (0.0, 0.0) }
    }

    /// Of a run of blocks: Σ a·b and Σ a² of twice the middle's departure a and the width b, both over what the run's neighbours say.
    fn widening(&self, axis: &Vector3<f64>, line: &Vector3<f64>, run: std::ops::Range<usize>) -> (f64, f64) {
        let over = |b: &Block| (2.0 * (b.middle - axis.dot(&basis(b.x))), b.width - line.dot(&basis(b.x)));
        let before = run.start.checked_sub(1).map(|k| over(&self.blocks[k]));
        let after = self.blocks.get(run.end).map(over);
        let (mut widening, mut square) = (0.0, 0.0);
        for (k, b) in self.blocks[run.clone()].iter().enumerate() {
            let share = (k as f64 + 1.0) / (run.len() as f64 + 1.0);
            let level = match (before, after) {
                (Some(one), Some(two)) => (one.0 + share * (two.0 - one.0), one.1 + share * (two.1 - one.1)),
                (Some(one), None) | (None, Some(one)) => one,
                (None, None) => (0.0, 0.0),
            };
            let (moved, width) = over(b);
            let moved = moved - level.0;
            widening += moved.abs() * (width - level.1);
            square += moved * moved;
        }
        (widening, square)
    }

    /// Spread about an axis, dearer where it bends.
    fn cost(&mut self, axis: &Vector3<f64>) -> f64 {
        self.spread(axis) * price(axis)
    }

    /// Whether an axis costs less than `cost`, told by counting: so many departures must be small that the quantile is.
    fn is_cheaper(&self, axis: &Vector3<f64>, cost: f64) -> bool {
        let limit = cost / (MEDIAN_TO_SD * price(axis));
        let (a, b, c) = (axis[0], axis[1], axis[2]);
        let near = |block: &Block| {
            let (x, m) = block.point();
            u32::from((m - (a + x * (b + x * c))).abs() < limit)
        };
        let agreeing: u32 = self.blocks.iter().map(near).sum();
        agreeing as usize > (AGREEING * self.blocks.len() as f64) as usize
    }

    /// Robust standard deviation of the blocks about an axis, px.
    fn spread(&mut self, axis: &Vector3<f64>) -> f64 {
        self.sizes.clear();
        self.sizes.extend(self.blocks.iter().map(|b| (b.middle - axis.dot(&basis(b.x))).abs()));
        robust_sd(&mut self.sizes)
    }

    /// Turns middles into departures; gives the robust standard deviations of a column and of a block, px.
    fn depart(&mut self, axis: &Vector3<f64>, columns: usize) -> (f64, f64) {
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
        // The scatter of a few blocks may be small by chance, but hardly smaller than that of its columns makes it.
        (column_sd, block_sd.max(column_sd * MEDIAN_OF_BLOCK))
    }

    /// Marks what departs, and what belongs to it; gives whether anything does. Where light falls off along the shaft, edges in its dim
    /// part scatter by more than the field does: what their own noise makes is no departure.
    fn mark(&mut self, (column_sd, block_sd): (f64, f64), edges: (&[Edge], &[Edge])) -> bool {
        let columns = self.departures.len();
        let column_limit = (COLUMN_LIMIT * column_sd).max(2.0 * FLOOR_PX) as f32;
        let block_limit = (BLOCK_LIMIT * block_sd).max(FLOOR_PX) as f32;
        let grow = (GROW_LIMIT * column_sd).max(0.5 * FLOOR_PX) as f32;
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
            if whole && sum.abs() > BLOCK_LIMIT as f32 * own * count.sqrt() {
                self.refused[place].fill(true);
                any = true;
                continue;
            }
            let limit = column_limit.max(COLUMN_LIMIT as f32 * own);
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
    fn refused_columns(&self) -> usize {
        self.refused.iter().zip(&self.departures).filter(|(r, d)| **r && d.is_finite()).count()
    }

    /// Extends refused stretches over neighbours that still depart to the same side, and a guard beyond.
    fn grow(&mut self, limit: f32) {
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
                while quiet < 4 && (at - seed).unsigned_abs() < GROWTH {
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
                let reach = (last + step * GUARD as isize).clamp(0, columns - 1);
                let (a, b) = (seed.min(reach) as usize, seed.max(reach) as usize);
                self.refused[a..=b].fill(true);
            }
        }
    }
}

/// Whether a block lies further than `limit` px from an axis.
fn far(axis: &Vector3<f64>, limit: f64, block: &Block) -> bool {
    (block.middle - axis.dot(&basis(block.x))).abs() > limit
}

/// What an axis costs for its bend.
fn price(axis: &Vector3<f64>) -> f64 {
    (1.0 + (axis[2] / USUAL_BEND_PX).powi(2)).sqrt()
}

/// The parabola through three points, or the line through the first and the last.
fn through(points: [(f64, f64); 3], bent: bool) -> Vector3<f64> {
    let [(x0, y0), (x1, y1), (x2, y2)] = points;
    let whole = (y2 - y0) / (x2 - x0);
    let bend = if bent { ((y1 - y0) / (x1 - x0) - whole) / (x1 - x2) } else { 0.0 };
    let slope = whole - bend * (x0 + x2);
    Vector3::new(y0 - x0 * (slope + bend * x0), slope, bend)
}

/// Parabola or line by least squares; `None` where the points do not tell it.
fn fit(points: impl Iterator<Item = (f64, f64)>, bent: bool) -> Option<Vector3<f64>> {
    let (mut normal, mut right) = (Matrix3::<f64>::zeros(), Vector3::<f64>::zeros());
    for (x, y) in points {
        let b = if bent { basis(x) } else { Vector3::new(1.0, x, 0.0) };
        normal += b * b.transpose();
        right += b * y;
    }
    if !bent {
        normal[(2, 2)] = 1.0;
    }
    normal.cholesky().map(|c| c.solve(&right))
}

#[cfg(test)]
mod tests;
