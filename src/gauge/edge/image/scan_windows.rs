//! Windows around the edges of one side: reading them, centring them, their flat ends.

use multiversion::multiversion;
use wide::f32x4;

use super::part_localisation::CoarseEdge;
use super::plane::{Plane, Sample};
use super::window_layout::{MOST_WIDTH, PHASE_REACH, half};
use crate::gauge::edge::model::edge_spread::EdgeSpreadFunction;
use crate::gauge::edge::model::gaussian::EdgeSample;
use crate::gauge::limit::limits;
use crate::profile::Reason;

limits! {
    /// When a window is centred on its edge.
    WindowLimits = "scan_windows";
    /// Distance of an edge from the central pixel up to which its window is centred, px: more than
    /// half a pixel, so that noise of 0.05 px (`frame_survey.noisy_area_px`) cannot alternate a
    /// window between two rows.
    central_px: f32 = 0.65;
    /// Distance left to the scoring where noise alternates a window, px: its own shifts reach that
    /// far.
    later_px: f32 = 2.5;
    /// Rows by which the edges in a tile of 64 columns may differ: a slope of 1/8. Steeper tiles
    /// are read column by column, which is slower and gives the same.
    most_spread: i32 = 8;
    /// Columns either side over which the slope of an edge is taken: first estimates good to 0.05
    /// px give it to 0.05·√2/16 = 0.004.
    slope_arm: usize = 8;
}

/// Columns of a tile: their pixels in a row fill one or two lines of the cache.
const TILE: usize = 64;
/// Columns that are turned into windows together: two vectors of four lanes.
const GROUP: usize = 8;

/// Upper or lower edge. Windows always run from shadow to light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Top,
    Bottom,
}

impl Side {
    /// Rows per window pixel.
    pub(crate) fn sign(self) -> i32 {
        if self == Self::Top { -1 } else { 1 }
    }
}

/// Level sums of a side before pooling.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LevelSums {
    pub(crate) dark: f64,
    pub(crate) light: f64,
    pub(crate) count: f64,
}

/// The windows of one side of a frame; slots without a window carry a reason. Columns of equal
/// length, not a vector of windows: levels and pixels are summed over neighbours, several at once.
#[derive(Clone, Debug)]
pub(crate) struct Windows {
    pub(crate) side: Side,
    pub(crate) width: usize,
    /// Flat pixels at each end.
    pub(crate) flat: usize,
    /// `width` counts a column.
    pub(crate) pixels: Vec<f32>,
    /// Row of the central pixel, or the reason for which there is no window.
    pub(crate) centre: Vec<CoarseEdge>,
    /// First estimate of the edge, px from the centre.
    pub(crate) start: Vec<f32>,
    /// Mean of the flat pixels in the shadow, counts; NaN without a window.
    pub(crate) dark: Vec<f32>,
    /// Mean of the flat pixels in the light, counts; NaN without a window.
    pub(crate) light: Vec<f32>,
    /// Whether the centres are final: then only the flat ends are evaluated.
    pub(crate) centred: bool,
    /// Position of the edge by the area of the light relative to the fitted one, px into the light.
    centroid: f32,
    tile: Vec<[f32; TILE]>,
    limits: &'static WindowLimits,
}

impl Windows {
    pub(crate) fn new(side: Side) -> Self {
        Self {
            side,
            width: 0,
            flat: 0,
            pixels: Vec::new(),
            centre: Vec::new(),
            start: Vec::new(),
            dark: Vec::new(),
            light: Vec::new(),
            centred: false,
            centroid: 0.0,
            tile: Vec::new(),
            limits: WindowLimits::get(),
        }
    }

    /// First estimate of a column's edge, px from its central pixel: windows that were centred on
    /// known edges have no other.
    pub(crate) fn first_place(&self, column: usize) -> f64 {
        if self.centred { 0.0 } else { f64::from(self.start[column]) }
    }

    /// Sets the width from the blur and makes room for a frame.
    pub(crate) fn prepare(&mut self, shape: &EdgeSpreadFunction, sigma: f64, width: usize, columns: usize) {
        self.width = width;
        self.centroid = shape.centroid(sigma) as f32;
        self.flat =
            ((half(width) as f64 - shape.reach(sigma) - f64::from(PHASE_REACH)).floor() as usize).max(3);
        if shape.is_ringed() {
            // Rings reach beyond the window: the area and the flat ends that an edge in the middle
            // has.
            let mut samples = vec![EdgeSample::default(); width];
            shape.samples(-(half(width) as f64), 0.0, sigma, &mut samples);
            let light: Vec<f32> = samples.iter().map(|s| s.value as f32).collect();
            self.centroid = area_start(&light, self.flat).2;
        }
        self.pixels.resize(columns * width, 0.0);
        for values in [&mut self.start, &mut self.dark, &mut self.light] {
            values.clear();
            values.resize(columns, f32::NAN);
        }
    }

    /// The window of a column.
    pub(crate) fn of(&self, column: usize) -> &[f32] {
        &self.pixels[column * self.width..(column + 1) * self.width]
    }

    /// Sums of the flat ends' levels over the columns with a window.
    pub(crate) fn level_sums(&self) -> LevelSums {
        let (mut dark_sums, mut light_sums, mut counts) = ([0.0_f64; 4], [0.0_f64; 4], [0.0_f64; 4]);
        let (darks, rest) = self.dark.as_chunks::<4>();
        let (lights, other) = self.light.as_chunks::<4>();
        for (dark, light) in darks.iter().zip(lights) {
            for k in 0..4 {
                let there = dark[k].is_finite();
                dark_sums[k] += if there { f64::from(dark[k]) } else { 0.0 };
                light_sums[k] += if there { f64::from(light[k]) } else { 0.0 };
                counts[k] += if there { 1.0 } else { 0.0 };
            }
        }
        for (dark, light) in rest.iter().zip(other).filter(|(dark, _)| dark.is_finite()) {
            (dark_sums[0], light_sums[0]) =
                (dark_sums[0] + f64::from(*dark), light_sums[0] + f64::from(*light));
            counts[0] += 1.0;
        }
        LevelSums { dark: dark_sums.iter().sum(), light: light_sums.iter().sum(), count: counts.iter().sum() }
    }

    /// Row of a place in a column's window; NaN without a window.
    pub(crate) fn row(&self, column: usize, x: f32) -> f64 {
        match self.centre[column] {
            Ok(row) => f64::from(row) + f64::from(self.side.sign()) * f64::from(x),
            Err(_) => f64::NAN,
        }
    }

    /// Place of a row in a column's window, px from its central pixel; NaN without a window.
    pub(crate) fn place(&self, column: usize, row: f64) -> f64 {
        match self.centre[column] {
            Ok(centre) => f64::from(self.side.sign()) * (row - f64::from(centre)),
            Err(_) => f64::NAN,
        }
    }

    /// Reads all windows whose centre is known, and centres them.
    pub(crate) fn read<T: Sample>(&mut self, plane: &Plane<'_, T>) {
        let mut tile = std::mem::take(&mut self.tile);
        tile.resize(self.limits.tile_rows(), [0.0; TILE]);
        for from in (0..plane.columns).step_by(TILE) {
            let to = (from + TILE).min(plane.columns);
            match self.tile_rows(plane, from, to) {
                Some(rows) => read_tile(self, plane, from, rows, &mut tile),
                None => (from..to).for_each(|column| self.read_one(plane, column, column)),
            }
        }
        self.tile = tile;
    }

    /// First and last row that a tile's windows and their neighbours to be centred on reach; `None`
    /// where the edge is too steep or broken, or near the border, for windows of one tile.
    fn tile_rows<T: Sample>(&self, plane: &Plane<'_, T>, from: usize, to: usize) -> Option<(i32, i32)> {
        let (mut low, mut high) = (i32::MAX, i32::MIN);
        for centre in &self.centre[from..to] {
            let row = centre.ok()?;
            (low, high) = (low.min(row), high.max(row));
        }
        if high - low > self.limits.most_spread || to - from < TILE || plane.column_stride != 1 {
            return None;
        }
        let (half, width) = (half(self.width) as i32, self.width as i32);
        let (before, after) =
            if self.side == Side::Bottom { (half, width - 1 - half) } else { (width - 1 - half, half) };
        let hop = i32::from(!self.centred);
        let (first, last) = (low - before - hop, high + after + hop);
        (first >= 0 && (last as usize) < plane.rows).then_some((first, last))
    }

    /// Copies the window of a column out of a tile, in which it begins at `begin`.
    #[inline(always)]
    fn copy_out(&mut self, tile: &[[f32; TILE]], lane: usize, column: usize, begin: usize) {
        let window = &mut self.pixels[column * self.width..(column + 1) * self.width];
        for (value, row) in window.iter_mut().zip(&tile[begin..]) {
            *value = row[lane];
        }
    }

    /// Takes one column out of a tile; false where its window has to be centred.
    fn take_one(&mut self, tile: &[[f32; TILE]], lane: usize, column: usize, begin: usize) -> bool {
        self.copy_out(tile, lane, column, begin);
        let window = self.of(column);
        if self.centred {
            (self.dark[column], self.light[column]) = flat_ends(window, self.flat);
            return true;
        }
        let (dark, light, area) = area_start(window, self.flat);
        let x = area - self.centroid;
        let central = self.limits.is_central(dark, light, x);
        if central {
            (self.start[column], self.dark[column], self.light[column]) = (x, dark, light);
        }
        central
    }

    /// Takes eight columns out of a tile whose windows all begin at `begin`; gives those that are
    /// still to be centred.
    #[inline(always)]
    fn take_group(
        &mut self,
        tile: &[[f32; TILE]],
        lane: usize,
        column: usize,
        begin: usize,
    ) -> [bool; GROUP] {
        let (width, flat, columns) = (self.width, self.flat, column..column + GROUP);
        let part = &tile[begin..begin + width];
        let out = &mut self.pixels[columns.start * width..columns.end * width];
        let mut open = [false; GROUP];
        if self.centred {
            turn_group(part, lane, out);
            let (dark, light) = group_ends(part, lane, flat);
            self.dark[columns.clone()].copy_from_slice(&dark);
            self.light[columns].copy_from_slice(&light);
            return open;
        }
        // An edge off by one pixel, as most are at first, is centred within the tile.
        let (centroid, at) = (self.centroid, |begin: usize| &tile[begin..begin + width]);
        let starts = [
            group_start(at(begin - 1), lane, flat, centroid),
            group_start(at(begin), lane, flat, centroid),
            group_start(at(begin + 1), lane, flat, centroid),
        ];
        let mut shifts = [0_usize; GROUP];
        for k in 0..GROUP {
            let [_, here, _] = &starts;
            let there = if self.limits.is_central(here.dark[k], here.light[k], here.x[k]) {
                1
            } else if here.x[k] > 0.0 {
                2
            } else {
                0
            };
            let start = &starts[there];
            open[k] = !self.limits.is_central(start.dark[k], start.light[k], start.x[k]);
            shifts[k] = there;
            if !open[k] {
                self.start[column + k] = start.x[k];
                (self.dark[column + k], self.light[column + k]) = (start.dark[k], start.light[k]);
                let shift = self.side.sign() * (there as i32 - 1);
                self.centre[column + k] = self.centre[column + k].map(|row| row + shift);
            }
        }
        let common = shifts[0];
        turn_group(&tile[begin + common - 1..begin + common - 1 + width], lane, out);
        for k in (0..GROUP).filter(|k| shifts[*k] != common) {
            self.copy_out(tile, lane + k, column + k, begin + shifts[k] - 1);
        }
        open
    }

    /// Reads and centres the window of a column into a place (the column's own, where all are
    /// read).
    pub(crate) fn read_one<T: Sample>(&mut self, plane: &Plane<'_, T>, column: usize, place: usize) {
        let Ok(mut centre) = self.centre[place] else { return };
        let half = half(self.width) as i32;
        let down = self.side == Side::Bottom;
        let window = &mut self.pixels[place * self.width..(place + 1) * self.width];
        for hop in 0..4 {
            let first = centre - self.side.sign() * half;
            if !plane.gather(first as isize, down, column, window) {
                self.centre[place] = Err(Reason::Border);
                return;
            }
            let (dark, light, area) = area_start(window, self.flat);
            let x = area - self.centroid;
            if !(light > dark) {
                break;
            }
            let shift = x.round();
            if x.abs() <= if hop < 3 && !self.centred { self.limits.central_px } else { self.limits.later_px }
            {
                self.centre[place] = Ok(centre);
                self.start[place] = x;
                self.dark[place] = dark;
                self.light[place] = light;
                return;
            }
            centre += self.side.sign() * shift.clamp(-64.0, 64.0) as i32;
        }
        self.centre[place] = Err(Reason::NoEdge);
    }
}

/// Reads a tile of neighbouring windows row by row, which uses the cache better than column by
/// column, and transposes it, eight columns at a time where their edges lie in the same row.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"), dispatcher = "direct")]
fn read_tile<T: Sample>(
    windows: &mut Windows,
    plane: &Plane<'_, T>,
    from: usize,
    (first, last): (i32, i32),
    tile: &mut [[f32; TILE]],
) {
    let down = windows.side == Side::Bottom;
    let rows = (last - first + 1) as usize;
    for (k, values) in tile[..rows].iter_mut().enumerate() {
        let row = if down { first as usize + k } else { last as usize - k };
        plane.read_tile_row(row, from, values);
    }
    let half = half(windows.width) as i32;
    let start = |row: i32| (if down { row - half - first } else { last - row - half }) as usize;
    for group in (0..TILE).step_by(GROUP) {
        let column = from + group;
        let Ok(centre) = windows.centre[column] else { continue };
        if windows.centre[column..column + GROUP].iter().all(|c| *c == Ok(centre)) {
            let open = windows.take_group(tile, group, column, start(centre));
            for k in (0..GROUP).filter(|k| open[*k]) {
                windows.read_one(plane, column + k, column + k);
            }
            continue;
        }
        for lane in group..group + GROUP {
            let column = from + lane;
            let Ok(row) = windows.centre[column] else { continue };
            if !windows.take_one(tile, lane, column, start(row)) {
                windows.read_one(plane, column, column);
            }
        }
    }
}

/// Turns the rows of eight columns of a tile into eight windows.
#[inline(always)]
fn turn_group(part: &[[f32; TILE]], lane: usize, out: &mut [f32]) {
    let width = part.len();
    for (block, rows) in part.as_chunks::<4>().0.iter().enumerate() {
        for four in [0, 4] {
            let load = |row: &[f32; TILE]| {
                row[lane + four..].first_chunk::<4>().map_or(f32x4::ZERO, |v| f32x4::from(*v))
            };
            let turned = f32x4::transpose([load(&rows[0]), load(&rows[1]), load(&rows[2]), load(&rows[3])]);
            for (k, values) in turned.into_iter().enumerate() {
                let at = (four + k) * width + 4 * block;
                out[at..at + 4].copy_from_slice(&values.to_array());
            }
        }
    }
}

/// Sums of eight columns over rows of a tile.
#[inline(always)]
fn group_sums(rows: &[[f32; TILE]], lane: usize) -> [f32; GROUP] {
    let mut sums = [0.0_f32; GROUP];
    for row in rows {
        if let Some(values) = row[lane..].first_chunk::<GROUP>() {
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += value;
            }
        }
    }
    sums
}

/// [`flat_ends`] of eight columns of a tile.
#[inline(always)]
fn group_ends(part: &[[f32; TILE]], lane: usize, flat: usize) -> ([f32; GROUP], [f32; GROUP]) {
    let (used, scale) = (part.len() - 1, 1.0 / flat as f32);
    let (mut dark, mut light) = (group_sums(&part[..flat], lane), group_sums(&part[used - flat..used], lane));
    dark.iter_mut().chain(&mut light).for_each(|sum| *sum *= scale);
    (dark, light)
}

/// [`area_start`] of eight columns of a tile, about the centroid.
struct GroupStart {
    dark: [f32; GROUP],
    light: [f32; GROUP],
    x: [f32; GROUP],
}

#[inline(always)]
fn group_start(part: &[[f32; TILE]], lane: usize, flat: usize, centroid: f32) -> GroupStart {
    let used = part.len() - 1;
    let (dark, light) = group_ends(part, lane, flat);
    let sums = group_sums(&part[..used], lane);
    let none = used as f32 - 0.5 - half(part.len()) as f32 - centroid;
    let mut x = [0.0; GROUP];
    for k in 0..GROUP {
        x[k] = none - (sums[k] - dark[k] * used as f32) / (light[k] - dark[k]);
    }
    GroupStart { dark, light, x }
}

impl WindowLimits {
    /// The most rows that the windows of a tile can span, with one more either side.
    fn tile_rows(&self) -> usize {
        MOST_WIDTH + self.most_spread as usize + 2
    }

    /// Whether a window with these flat ends and this edge is centred.
    #[inline(always)]
    fn is_central(&self, dark: f32, light: f32, x: f32) -> bool {
        light > dark && x.abs() <= self.central_px
    }
}

/// Means of the flat ends, in the shadow and in the light.
#[inline(always)]
fn flat_ends(window: &[f32], flat: usize) -> (f32, f32) {
    let used = window.len() - 1;
    let scale = 1.0 / flat as f32;
    let dark = window[..flat].iter().sum::<f32>() * scale;
    let light = window[used - flat..used].iter().sum::<f32>() * scale;
    (dark, light)
}

/// Levels from the flat ends and the edge from the area between them, px from the central pixel.
fn area_start(window: &[f32], flat: usize) -> (f32, f32, f32) {
    let used = window.len() - 1;
    let (dark, light) = flat_ends(window, flat);
    let mut lanes = [0.0_f32; 8];
    for chunk in window.chunks_exact(8) {
        for (lane, value) in lanes.iter_mut().zip(chunk) {
            *lane += value;
        }
    }
    let sum = lanes.iter().sum::<f32>() - window[used];
    let area = (sum - dark * used as f32) / (light - dark);
    (dark, light, used as f32 - 0.5 - half(window.len()) as f32 - area)
}
/// Slope of the edge line, rows per column, from first estimates up to eight columns either side; 0
/// where there are none.
pub(crate) fn slopes(windows: &Windows, out: &mut Vec<f32>) {
    let limits = WindowLimits::get();
    let columns = windows.centre.len();
    let known = |column: usize| windows.centre[column].is_ok();
    out.clear();
    for column in 0..columns {
        let (from, to) =
            (column.saturating_sub(limits.slope_arm), (column + limits.slope_arm).min(columns - 1));
        let left = if known(from) { Some(from) } else { (from..=column).find(|c| known(*c)) };
        let right = if known(to) { Some(to) } else { (column..=to).rev().find(|c| known(*c)) };
        out.push(match (left, right) {
            (Some(l), Some(r)) if r > l => {
                let rise = windows.row(r, windows.start[r]) - windows.row(l, windows.start[l]);
                (rise / (r - l) as f64) as f32
            }
            _ => 0.0,
        });
    }
}
