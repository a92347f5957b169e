//! What the second trees are given of a pixel beside its features: what the first ones found about
//! it (auto-context: Tu, Auto-context and its application to high-level vision tasks, CVPR 2008).
//!
//! In: probabilities of land below the reference. Out: [`CONTEXT`] rasters of the same size: the
//! smoothed probability at the pixel, above, below and along the edge, its means between the edge
//! and the pixel and below it, the distances from the border that it gives alone (the median over
//! 80 µm on each side, and over 400 µm), and the depth over that of the wider one: lands are of
//! nearly even width, and where glare, a shadow or adhering material hides a stretch of the border
//! the others show how deep it lies.

use super::features::{mean_of, sums_down};
use super::limits::FlankLimits;
use super::raster::{Raster, quantile};

/// Features from the first trees.
pub(crate) const CONTEXT: usize = 14;
/// The context of every pixel; `border` is the first trees' border in every column, rows.
pub(crate) fn context(probability: &Raster, border: &[usize]) -> Vec<Raster> {
    let soft = probability.blurred(1.5, 3.0);
    let mut all = vec![soft.clone()];
    // 12, 30 and 60 µm above and below
    for by in [-15, -6, 6, 15, 30] {
        all.push(moved(&soft, by));
    }
    all.push(probability.blurred(1.5, 12.0));
    all.push(probability.blurred(3.0, 36.0));
    let total = sums_down(&probability.blurred(0.0, 8.0));
    all.push(mean_of(&total, |row| (0, row + 1)));
    // 40 and 120 µm
    for rows in [20, 60] {
        let last = probability.rows;
        all.push(mean_of(&total, move |row| ((row + 1).min(last - 1), (row + 1 + rows).min(last))));
    }
    let limits = FlankLimits::get();
    all.push(distance(probability, &medians(border, limits.context_columns), limits.context_rows));
    let wide = medians(border, limits.context_wide_columns);
    all.push(distance(probability, &wide, limits.context_wide_rows));
    all.push(relative(probability, &wide));
    all
}

fn moved(of: &Raster, by: i64) -> Raster {
    let from = |row: usize| (row as i64 + by).clamp(0, of.rows as i64 - 1) as usize;
    Raster { values: (0..of.rows).flat_map(|row| of.row(from(row)).to_vec()).collect(), ..*of }
}

/// Running median of a border over so many columns on each side.
fn medians(border: &[usize], beside: usize) -> Vec<f32> {
    let of = |column: usize| {
        let about = column.saturating_sub(beside)..(column + beside + 1).min(border.len());
        quantile(border[about].iter().map(|b| *b as f32).collect(), 0.5)
    };
    (0..border.len()).map(of).collect()
}

/// Rows from a border, as far as `most`.
fn distance(like: &Raster, border: &[f32], most: usize) -> Raster {
    let most = most as f32;
    filled(like, |row, column| (row - border[column]).clamp(-most, most))
}

/// Depth over that of a border, at most 4; a border at the edge counts as five rows deep.
fn relative(like: &Raster, border: &[f32]) -> Raster {
    filled(like, |row, column| (row / border[column].max(5.0)).min(4.0))
}

fn filled(like: &Raster, value: impl Fn(f32, usize) -> f32) -> Raster {
    let mut out = Raster::new(like.rows, like.columns);
    for row in 0..like.rows {
        for column in 0..like.columns {
            out.values[row * like.columns + column] = value(row as f32, column);
        }
    }
    out
}
