//! The step of the grey scale: 1 count in most frames, 16 in 12-bit values shifted into 16 bits,
//! 257 in 8-bit values stretched to them, 1/255 in floats that hold eight bits. The step determines
//! the effect of rounding on an edge.

use super::part_localisation::CoarseEdge;
use super::plane::{Plane, Sample};
use crate::gauge::limit::limits;

limits! {
    /// When gaps between grey values are the step of a scale.
    GreyStepLimits = "grey_step";
    /// Number of different floats from which on their least distance is a step: a gap of two or
    /// three steps is a multiple within `near` by chance once in ten, the gaps of sixteen values
    /// once in 10¹⁴.
    enough_values: usize = 16;
    /// Distance from a multiple of the step, counts, up to which a stretched value is one: half a
    /// count by its own rounding, and a quarter, the mean size of the rounding of the value that is
    /// counted from.
    rounded: f64 = 0.75;
    /// Difference of the steps tried, counts: a step that is off by half of it moves its 512th
    /// multiple by half a count.
    finest: f64 = 1.0 / 512.0;
    /// False-alarm probability: grey values of a scale of single counts show a larger step by
    /// chance in one frame of 10⁴.
    chance: f64 = 1e-4;
    /// Distance from a multiple of the step, in steps and of that multiple, up to which a float is
    /// one: what conversions to f32 and back leave is far less. Tuned: see study limits.
    near: f32 = 0.02;
}

/// Columns looked at, and pixels across either edge of each: the grey values between shadow and
/// light are the many ones. Lengths of an array: 2304 values show a step of 8 bits in most of its
/// places.
const COLUMNS: usize = 48;
const ACROSS: usize = 24;

/// The step of a frame's grey values around its edges, counts; 0 for floats without one.
pub(crate) fn grey_step<T: Sample>(
    plane: &Plane<'_, T>,
    edges: [&Vec<CoarseEdge>; 2],
    whole_counts: bool,
) -> f64 {
    let limits = GreyStepLimits::get();
    let mut grid = [0.0_f32; 2 * COLUMNS * ACROSS];
    let step = plane.columns.div_ceil(COLUMNS).max(1);
    let places = edges.into_iter().flat_map(|line| line.iter().enumerate().step_by(step)).flat_map(
        |(column, edge)| {
            let row = edge.map_or(0, |row| (row as usize).saturating_sub(ACROSS / 2));
            let rows = if edge.is_ok() { row..(row + ACROSS).min(plane.rows) } else { 0..0 };
            rows.map(move |row| (row, column))
        },
    );
    let mut looked_at = 0;
    for (value, (row, column)) in grid.iter_mut().zip(places) {
        *value = plane.at(row, column);
        looked_at += 1;
    }
    grid[..looked_at].sort_unstable_by(f32::total_cmp);
    let mut different = 0;
    for k in 0..looked_at {
        if different == 0 || grid[k] > grid[different - 1] {
            grid[different] = grid[k];
            different += 1;
        }
    }
    let values = &grid[..different];
    let unit = if whole_counts { 1.0 } else { 0.0 };
    // Values that hardly ever occur twice have no detectable step.
    if values.len() < 2 || (!whole_counts && 2 * values.len() > looked_at) {
        return unit;
    }
    let gaps = || values.windows(2).map(|w| w[1] - w[0]);
    let least = gaps().fold(f32::INFINITY, f32::min);
    if whole_counts {
        let divisor = gaps().fold(0, |d, gap| greatest_common_divisor(d, gap as u32));
        if divisor > 1 {
            return if is_chance(values.len(), divisor) { unit } else { f64::from(divisor) };
        }
        return lattice(values, f64::from(least)).max(unit);
    }
    let multiple =
        |gap: f32| (gap / least - (gap / least).round()).abs() < limits.near * (gap / least).max(1.0);
    if values.len() >= limits.enough_values && gaps().all(multiple) { f64::from(least) } else { 0.0 }
}

/// Whether so many grey values of a scale of single counts have gaps with a common divisor by
/// chance: the first gap gives one, each further gap is a multiple of it with probability
/// 1/divisor. Two values, of a drawn or thresholded picture, show no step.
fn is_chance(values: usize, divisor: u32) -> bool {
    (2.0 - values as f64) * f64::from(divisor).ln() > GreyStepLimits::get().chance.ln()
}

/// The step near `least` that all values are rounded multiples of, counted from the first; 1 where
/// there is none, or where values without a step would show one by chance: each of them lies within
/// ± 3/4 count of a multiple with probability 1.5/step.
fn lattice(values: &[f32], least: f64) -> f64 {
    let limits = GreyStepLimits::get();
    if (values.len() as f64 - 2.0) * (1.5 / least).ln() > limits.chance.ln() {
        return 1.0;
    }
    let tries = (2.0 / limits.finest) as usize;
    let fits = |step: f64| {
        values.iter().all(|v| {
            let far = f64::from(*v) - f64::from(values[0]);
            (far - step * (far / step).round()).abs() <= limits.rounded
        })
    };
    // The largest that fits: every fraction of a step fits, too.
    (0..tries).rev().map(|k| least - 1.0 + k as f64 * limits.finest).find(|step| fits(*step)).unwrap_or(1.0)
}

fn greatest_common_divisor(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

#[cfg(test)]
mod tests;
