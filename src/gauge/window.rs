//! Windows around the edges of one side: reading them, centring them, their flat ends.

use super::coarse::CoarseEdge;
use super::esf::EdgeShape;
use super::pixels::{Plane, Sample};
use super::table::{PHASE_REACH, half};
use crate::profile::Reason;

/// An edge this close to the central pixel is centred, px. More than half a pixel, so that noise cannot keep a window hopping.
const CENTRED: f32 = 0.65;

/// What is left to the scoring where noise keeps a window hopping, px: its own shifts reach that far.
const LATER: f32 = 2.5;

/// Columns of a tile, and the most rows that its windows can span.
const TILE: usize = 32;
const TILE_ROWS: usize = 72 + 8;

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

/// The windows of one side of a frame; slots without a window carry a reason.
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
    /// Whether the centres are known to be right: then only the flat ends are looked at.
    pub(crate) centred: bool,
    /// Where the area of the light puts the edge, px into the light from where it is.
    centroid: f32,
    tile: Vec<[f32; TILE]>,
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
        }
    }

    /// Sets the width from the blur and makes room for a frame.
    pub(crate) fn prepare(&mut self, shape: &EdgeShape, sigma: f64, width: usize, columns: usize) {
        self.width = width;
        self.centroid = shape.centroid(sigma) as f32;
        self.flat =
            ((half(width) as f64 - shape.reach(sigma) - f64::from(PHASE_REACH)).floor() as usize).max(3);
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

    /// Row of a place in a column's window; NaN without a window.
    pub(crate) fn row(&self, column: usize, x: f32) -> f64 {
        match self.centre[column] {
            Ok(row) => f64::from(row) + f64::from(self.side.sign()) * f64::from(x),
            Err(_) => f64::NAN,
        }
    }

    /// Reads all windows whose centre is known, and centres them.
    pub(crate) fn read<T: Sample>(&mut self, plane: &Plane<'_, T>) {
        for from in (0..plane.columns).step_by(TILE) {
            let to = (from + TILE).min(plane.columns);
            if !self.read_tile(plane, from, to) {
                for column in from..to {
                    self.read_one(plane, column);
                }
            }
        }
    }

    /// Reads a tile of neighbouring windows row by row, which the cache likes better than column by column. False where the
    /// edge is too steep or broken, or near the border, for windows of one tile.
    fn read_tile<T: Sample>(&mut self, plane: &Plane<'_, T>, from: usize, to: usize) -> bool {
        let (mut low, mut high) = (i32::MAX, i32::MIN);
        for centre in &self.centre[from..to] {
            let Ok(row) = centre else { return false };
            (low, high) = (low.min(*row), high.max(*row));
        }
        let (half, width) = (half(self.width) as i32, self.width as i32);
        let (before, after) =
            if self.side == Side::Bottom { (half, width - 1 - half) } else { (width - 1 - half, half) };
        let (first, last) = (low - before, high + after);
        let rows = (last - first + 1) as usize;
        if high - low > 8
            || first < 0
            || last as usize >= plane.rows
            || to - from < TILE
            || plane.column_stride != 1
        {
            return false;
        }
        let mut tile = std::mem::take(&mut self.tile);
        tile.resize(TILE_ROWS, [0.0; TILE]);
        for (row, values) in tile[..rows].iter_mut().enumerate() {
            plane.read_row(first as usize + row, from, values);
        }
        for column in from..to {
            let Ok(centre) = self.centre[column] else { continue };
            let window = &mut self.pixels[column * self.width..(column + 1) * self.width];
            let start = (centre - before - first) as usize;
            let part = &tile[start..start + window.len()];
            if self.side == Side::Bottom {
                for (value, row) in window.iter_mut().zip(part) {
                    *value = row[column - from];
                }
            } else {
                for (value, row) in window.iter_mut().zip(part.iter().rev()) {
                    *value = row[column - from];
                }
            }
            if self.centred {
                (self.dark[column], self.light[column]) = flat_ends(window, self.flat);
                continue;
            }
            let (dark, light, area) = area_start(window, self.flat);
            let x = area - self.centroid;
            if light > dark && x.abs() <= CENTRED {
                self.start[column] = x;
                self.dark[column] = dark;
                self.light[column] = light;
            } else {
                self.read_one(plane, column);
            }
        }
        self.tile = tile;
        true
    }

    fn read_one<T: Sample>(&mut self, plane: &Plane<'_, T>, column: usize) {
        let Ok(mut centre) = self.centre[column] else { return };
        let half = half(self.width) as i32;
        let down = self.side == Side::Bottom;
        let window = &mut self.pixels[column * self.width..(column + 1) * self.width];
        for hop in 0..4 {
            let first = centre - self.side.sign() * half;
            if !plane.gather(first as isize, down, column, window) {
                self.centre[column] = Err(Reason::Border);
                return;
            }
            let (dark, light, area) = area_start(window, self.flat);
            let x = area - self.centroid;
            if !(light > dark) {
                break;
            }
            let shift = x.round();
            if x.abs() <= if hop < 3 { CENTRED } else { LATER } {
                self.centre[column] = Ok(centre);
                self.start[column] = x;
                self.dark[column] = dark;
                self.light[column] = light;
                return;
            }
            centre += self.side.sign() * shift.clamp(-64.0, 64.0) as i32;
        }
        self.centre[column] = Err(Reason::NoEdge);
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
