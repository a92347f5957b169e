//! Stuck rows of the sensor beside an edge: the windows that they cross are left out.
//!
//! A row is stuck where, in nearly all columns, it stands above both neighbours or below both by a
//! fifth of the contrast (an edge is monotone, a fringe's crest wider than a pixel), or where it
//! has one value all along and neither neighbour has.

use super::plane::{Plane, Sample};
use super::scan_windows::Windows;
use super::window_layout::half;
use crate::gauge::limit::limits;
use crate::profile::Reason;

limits! {
    /// When a row beside an edge is stuck.
    StuckRowLimits = "stuck_rows";
    /// Departure from both neighbours over the contrast: an edge is monotone and a fringe's crest
    /// wider than a pixel, so that of a live row noise alone departs, less than a fifth in nearly
    /// all columns.
    departure: f32 = 0.2;
    /// Share of the columns that must depart to the same side: all but those where the stuck value
    /// lies between its neighbours, along a slanted edge. Tuned: see study limits.
    nearly_all: f64 = 0.9;
    /// Share of the columns that have one value in a stuck row: all but hot pixels. Tuned: see
    /// study limits.
    alike: f64 = 0.95;
    /// Share of the columns that may repeat the column before in the live rows beside it: of
    /// Gaussian noise with a standard deviation of one count a quarter do.
    alive: f64 = 0.6;
    /// Least range of a live row's grey values, counts: less may be one level and its rounding,
    /// which gives two values.
    least_range: f32 = 3.0;
    /// Columns looked at, at most: a share of 0.9 is known to 4 % from 64.
    samples: usize = 64;
    /// Fewest columns that show a row: noise is above both neighbours once in three, in eight
    /// columns once in 6500.
    least: usize = 8;
}

/// A stuck row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StuckRow {
    pub(crate) row: usize,
    /// Grey value in the first column looked at, counts; negative for a lit part's frame.
    pub(crate) level: f32,
    /// Share of the side's columns whose windows it crosses.
    pub(crate) share: f64,
}

/// What a stuck row shows in the first column looked at, counts.
#[derive(Clone, Copy, Debug)]
struct Level {
    counts: f32,
    /// By how much it stands above or below both neighbours.
    departure: f32,
}

/// Leaves out the windows of a side that stuck rows cross; returns the row that crosses most of
/// them.
pub(crate) fn leave_out<T: Sample>(
    plane: &Plane<'_, T>,
    windows: &mut Windows,
    contrast: f32,
) -> Option<StuckRow> {
    let reach = half(windows.width) as i32 + 1;
    let known = || windows.centre.iter().flatten();
    let (low, high) = (known().min()? - reach, known().max()? + reach);
    let last = plane.rows as i32 - 2;
    let stuck: Vec<(usize, Level)> = (low.max(1)..=high.min(last))
        .filter_map(|row| Some((row as usize, level_if_stuck(plane, windows, row, (reach, contrast))?)))
        .collect();
    // A row beside a stuck one may stand apart from it and from the edge: of neighbours the one
    // that departs by more is stuck.
    let outdone =
        |row: usize, by: f32| stuck.iter().any(|(other, l)| other.abs_diff(row) == 1 && l.departure > by);
    let mut most: Option<StuckRow> = None;
    for (row, Level { counts: level, departure }) in stuck.iter().copied() {
        if outdone(row, departure) {
            continue;
        }
        let crosses = |c: i32| (row as i32 - c).abs() <= reach;
        let crossed: Vec<usize> =
            (0..windows.centre.len()).filter(|k| windows.centre[*k].is_ok_and(crosses)).collect();
        let share = crossed.len() as f64 / windows.centre.len() as f64;
        for column in crossed {
            windows.centre[column] = Err(Reason::Residual);
            (windows.dark[column], windows.light[column]) = (f32::NAN, f32::NAN);
        }
        if most.is_none_or(|m| share > m.share) {
            most = Some(StuckRow { row, level, share });
        }
    }
    most
}

/// Level of a row in the windows that reach it, where it is stuck.
fn level_if_stuck<T: Sample>(
    plane: &Plane<'_, T>,
    windows: &Windows,
    row: i32,
    (reach, contrast): (i32, f32),
) -> Option<Level> {
    let limits = StuckRowLimits::get();
    let step = windows.centre.len().div_ceil(limits.samples).max(1);
    let in_reach = |k: &usize| windows.centre[*k].is_ok_and(|c| (row - c).abs() <= reach);
    let (mut above, mut below, mut count) = (0, 0, 0);
    let (mut equal, mut repeated) = (0, [0; 3]);
    let mut range = [(f32::INFINITY, f32::NEG_INFINITY); 3];
    let mut first: Option<[f32; 3]> = None;
    let mut before = [f32::NAN; 3];
    for column in (0..windows.centre.len()).step_by(step).filter(in_reach) {
        let values = [-1, 0, 1].map(|k| plane.at((row + k) as usize, column));
        let [upper, own, lower] = values;
        above += usize::from(own > upper.max(lower) + limits.departure * contrast);
        below += usize::from(own < upper.min(lower) - limits.departure * contrast);
        equal += usize::from(own.to_bits() == first.get_or_insert(values)[1].to_bits());
        for ((repeated, value), before) in repeated.iter_mut().zip(values).zip(before) {
            *repeated += usize::from(value.to_bits() == before.to_bits());
        }
        before = values;
        for ((low, high), value) in range.iter_mut().zip(values) {
            (*low, *high) = (low.min(value), high.max(value));
        }
        count += 1;
    }
    // From one column to the next: a row without noise in which one pixel is hot or dead has a
    // range, and may begin with that pixel, but does not scatter.
    let scatters = |k: usize| {
        range[k].1 - range[k].0 >= limits.least_range && share_of(repeated[k], count) <= limits.alive
    };
    let departs = share_of(above.max(below), count) >= limits.nearly_all;
    let dead = share_of(equal, count) >= limits.alike && scatters(0) && scatters(2);
    let level = |[upper, own, lower]: [f32; 3]| Level {
        counts: own,
        departure: (own - upper.max(lower)).max(upper.min(lower) - own).max(0.0),
    };
    first.filter(|_| count >= limits.least && (departs || dead)).map(level)
}

fn share_of(part: usize, all: usize) -> f64 {
    part as f64 / all.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauge::edge::image::scan_windows::Side;

    /// Whether the middle one of three rows is stuck that departs from both others by half of the
    /// contrast in so many of sixty columns, and lies between them in the rest.
    fn is_stuck(departing: usize) -> bool {
        let columns = 60;
        let middle = |k: usize| if k < departing { 150.0 + k as f32 } else { 50.0 };
        let pixels: Vec<f32> = (0..3 * columns)
            .map(|i| match i / columns {
                0 => 40.0,
                1 => middle(i % columns),
                _ => 60.0,
            })
            .collect();
        let plane =
            Plane { pixels: &pixels, rows: 3, columns, row_stride: columns, column_stride: 1, sign: 1.0 };
        let mut windows = Windows::new(Side::Bottom);
        windows.centre = vec![Ok(1); columns];
        level_if_stuck(&plane, &windows, 1, (4, 180.0)).is_some()
    }

    /// Along a slanted edge a stuck value lies between its neighbours in a few columns in a
    /// hundred; a row that does so in one column of seven is alive.
    #[test]
    fn a_stuck_row_departs_in_nearly_all_columns() {
        assert!(is_stuck(56));
        assert!(!is_stuck(51));
    }
}
