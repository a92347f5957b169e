//! The worn land: from probabilities of pixels to its border in every column.
//!
//! A border at a row makes all pixels above it land and all below it not: its cost is the sum of
//! the log-odds against that, and the path of least cost through the strip is the border.

use rayon::prelude::*;

use super::features::features;
use super::forest::Forest;
use super::limits::FlankLimits;
use super::path::Costs;
use super::raster::Raster;
use super::strip::{Frame, normalised};

/// The border of the land.
#[derive(Clone, Debug)]
pub(crate) struct Land {
    /// Depth of the border below the reference in every column, µm.
    pub depth_um: Vec<f64>,
    /// Its standard uncertainty in every column, µm.
    pub u_um: Vec<f64>,
    /// Depth of the border by each group of the forest's trees, µm.
    pub by_group_um: Vec<Vec<f64>>,
}

/// Finds the border in a strip; `inside` are the rows of each column within the image.
pub(crate) fn land(strip: &Raster, frame: &Frame, inside: &[usize], forest: &Forest) -> Land {
    let all = features(&normalised(strip, frame), frame);
    let row_um = frame.row_um();
    let depth_um = |path: &[usize]| path.iter().map(|v| *v as f64 * row_um).collect::<Vec<f64>>();
    let by_group =
        |group: Forest| depth_um(&costs(&probability(&all, strip, frame, &group), frame, inside).cheapest());
    let by_group_um = forest.groups(FlankLimits::get().tree_groups).into_par_iter().map(by_group).collect();
    let probability = probability(&all, strip, frame, forest);
    let costs = costs(&probability, frame, inside);
    let path = costs.cheapest();
    let spread = costs.spread(&path, FlankLimits::get().temperature as f32);
    Land {
        depth_um: depth_um(&path),
        u_um: spread.iter().map(|s| (s * row_um).hypot(row_um / 12f64.sqrt())).collect(),
        by_group_um,
    }
}

fn probability(all: &[Raster], strip: &Raster, frame: &Frame, forest: &Forest) -> Raster {
    let mut out = Raster::new(frame.below, strip.columns);
    out.values.par_chunks_mut(strip.columns).enumerate().for_each(|(row, line)| {
        for (column, value) in line.iter_mut().enumerate() {
            let at = (row + frame.above) * strip.columns + column;
            *value = forest.probability(|k| all[k].values[at]);
        }
    });
    out
}

fn costs(probability: &Raster, frame: &Frame, inside: &[usize]) -> Costs {
    let limits = FlankLimits::get();
    let most = limits.most_log_odds as f32;
    let column = |c: usize| {
        let rows = inside[c].saturating_sub(frame.above).min(probability.rows);
        let mut sum = 0.0;
        let mut all = Vec::with_capacity(probability.rows + 1);
        all.push(0.0);
        for row in 0..probability.rows {
            let p = probability.at(row, c).clamp(1e-3, 1.0 - 1e-3);
            let odds = ((1.0 - p) / p).ln().clamp(-most, most);
            sum += if row < rows { odds } else { most };
            all.push(sum);
        }
        all
    };
    Costs {
        columns: (0..probability.columns).map(column).collect(),
        step: limits.step_cost as f32,
        most_step: limits.most_step,
    }
}
