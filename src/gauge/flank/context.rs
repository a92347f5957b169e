//! What the second trees are given of a pixel beside its features: what the first ones found about
//! it (auto-context: Tu, Auto-context and its application to high-level vision tasks, CVPR 2008).
//!
//! In: probabilities of land below the reference. Out: [`CONTEXT`] rasters of the same size: the
//! smoothed probability at the pixel, above, below and along the edge, its means between the edge
//! and the pixel and below it, and the distance from the border that it gives alone.

use super::raster::{Raster, quantile};

/// Features from the first trees.
pub(crate) const CONTEXT: usize = 12;
/// Rows above and below at which the probability is looked at: 12, 30 and 60 µm.
const ROWS: [i64; 5] = [-15, -6, 6, 15, 30];
/// Rows over which the probability below a pixel is averaged: 40 and 120 µm.
const BELOW: [usize; 2] = [20, 60];
/// Columns on each side over which the median of the first border goes: 80 µm.
const BORDER_COLUMNS: usize = 20;
/// Largest distance from the first border that is told apart, rows.
const MOST_ROWS: f32 = 40.0;

/// The context of every pixel; `border` is the first trees' border in every column, rows.
pub(crate) fn context(probability: &Raster, border: &[usize]) -> Vec<Raster> {
    let soft = probability.blurred(1.5, 3.0);
    let mut all = vec![soft.clone()];
    for by in ROWS {
        all.push(moved(&soft, by));
    }
    all.push(probability.blurred(1.5, 12.0));
    all.push(probability.blurred(3.0, 36.0));
    let total = sums_down(&probability.blurred(0.0, 8.0));
    all.push(means(&total, |row| (0, row + 1)));
    for rows in BELOW {
        let last = probability.rows;
        all.push(means(&total, move |row| ((row + 1).min(last - 1), (row + 1 + rows).min(last))));
    }
    all.push(distance(probability, border));
    all
}

fn moved(of: &Raster, by: i64) -> Raster {
    let from = |row: usize| (row as i64 + by).clamp(0, of.rows as i64 - 1) as usize;
    Raster { values: (0..of.rows).flat_map(|row| of.row(from(row)).to_vec()).collect(), ..*of }
}

fn sums_down(from: &Raster) -> Raster {
    let mut total = Raster::new(from.rows + 1, from.columns);
    for row in 0..from.rows {
        for column in 0..from.columns {
            total.values[(row + 1) * from.columns + column] = total.at(row, column) + from.at(row, column);
        }
    }
    total
}

fn means(total: &Raster, range: impl Fn(usize) -> (usize, usize)) -> Raster {
    let mut out = Raster::new(total.rows - 1, total.columns);
    for row in 0..out.rows {
        let (a, b) = range(row);
        for column in 0..total.columns {
            out.values[row * total.columns + column] =
                (total.at(b, column) - total.at(a, column)) / (b - a).max(1) as f32;
        }
    }
    out
}

/// Rows from the running median of the first border, within ±[`MOST_ROWS`].
fn distance(like: &Raster, border: &[usize]) -> Raster {
    let mut out = Raster::new(like.rows, like.columns);
    for column in 0..like.columns {
        let about = column.saturating_sub(BORDER_COLUMNS)..(column + BORDER_COLUMNS + 1).min(border.len());
        let middle = quantile(border[about].iter().map(|b| *b as f32).collect(), 0.5);
        for row in 0..like.rows {
            out.values[row * like.columns + column] = (row as f32 - middle).clamp(-MOST_ROWS, MOST_ROWS);
        }
    }
    out
}
