//! What the second trees are given of a pixel beside its features: what the first ones found about
//! it (auto-context: Tu, Auto-context and its application to high-level vision tasks, CVPR 2008).
//!
//! In: probabilities of land below the reference. Out: [`CONTEXT`] rasters of the same size: the
//! smoothed probability at the pixel, above, below and along the edge, its means between the edge
//! and the pixel and below it, and the distance from the border that it gives alone.

use super::features::{mean_of, sums_down};
use super::limits::FlankLimits;
use super::raster::{Raster, quantile};

/// Features from the first trees.
pub(crate) const CONTEXT: usize = 12;
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
    all.push(distance(probability, border));
    all
}

fn moved(of: &Raster, by: i64) -> Raster {
    let from = |row: usize| (row as i64 + by).clamp(0, of.rows as i64 - 1) as usize;
    Raster { values: (0..of.rows).flat_map(|row| of.row(from(row)).to_vec()).collect(), ..*of }
}

/// Rows from the running median of the first border, as far as `context_rows`.
fn distance(like: &Raster, border: &[usize]) -> Raster {
    let limits = FlankLimits::get();
    let (beside, most) = (limits.context_columns, limits.context_rows as f32);
    let mut out = Raster::new(like.rows, like.columns);
    for column in 0..like.columns {
        let about = column.saturating_sub(beside)..(column + beside + 1).min(border.len());
        let middle = quantile(border[about].iter().map(|b| *b as f32).collect(), 0.5);
        for row in 0..like.rows {
            out.values[row * like.columns + column] = (row as f32 - middle).clamp(-most, most);
        }
    }
    out
}
