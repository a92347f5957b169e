//! The worn land: from probabilities of pixels to its border in every column.
//!
//! A border at a row makes all pixels above it land and all below it not: its cost is the sum of
//! the log-odds against that, and the path of least cost through the strip is the border. The
//! second trees see what the first ones found about a pixel (`context`). Probabilities may come
//! from elsewhere too ([`border`]).

use rayon::prelude::*;

use super::context::context;
use super::features::features;
use super::forest::tree::Tree;
use super::forest::{Forest, share};
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
    /// Depth of the border by each group of the forest's trees, or each way in which another model
    /// was asked, µm.
    pub by_group_um: Vec<Vec<f64>>,
}

/// Finds the border in a strip by a forest; `inside` are the rows of each column within the image.
pub(crate) fn land(strip: &Raster, frame: &Frame, inside: &[usize], forest: &Forest) -> Land {
    let limits = FlankLimits::get();
    let mut all = below(&features(&normalised(strip, frame), frame), frame);
    if !forest.second.is_empty() {
        all.extend(first_context(&all, frame, inside, &forest.trees));
    }
    let trees = if forest.second.is_empty() { &forest.trees } else { &forest.second };
    border(&by_group(&all, trees, limits.tree_groups), frame, inside)
}

/// The border from probabilities of land below the reference, one raster a group, all of one
/// weight; their disagreement is in `by_group_um`.
pub(super) fn border(groups: &[Raster], frame: &Frame, inside: &[usize]) -> Land {
    let limits = FlankLimits::get();
    let row_um = frame.row_um();
    let depth_um = |path: &[usize]| path.iter().map(|v| *v as f64 * row_um).collect::<Vec<f64>>();
    let by_group_um =
        groups.par_iter().map(|p| depth_um(&costs(p, frame, inside).cheapest())).collect::<Vec<_>>();
    let costs = costs(&mean(groups), frame, inside);
    let path = costs.cheapest();
    let spread = costs.spread(&path, limits.temperature as f32);
    Land {
        depth_um: depth_um(&path),
        u_um: spread.iter().map(|s| (s * row_um).hypot(row_um / 12f64.sqrt())).collect(),
        by_group_um,
    }
}

/// The part of every raster below the reference.
pub(super) fn below(all: &[Raster], frame: &Frame) -> Vec<Raster> {
    let cut = |r: &Raster| Raster {
        rows: frame.below,
        columns: r.columns,
        values: r.values[frame.above * r.columns..].to_vec(),
    };
    all.iter().map(cut).collect()
}

/// What the first trees find, as features of the second.
pub(super) fn first_context(all: &[Raster], frame: &Frame, inside: &[usize], trees: &[Tree]) -> Vec<Raster> {
    let probability = mean(&by_group(all, trees, 1));
    let border = costs(&probability, frame, inside).cheapest();
    context(&probability, &border)
}

/// Probabilities by the trees dealt out to so many groups; of fewer trees a tree a group.
fn by_group(all: &[Raster], trees: &[Tree], count: usize) -> Vec<Raster> {
    let (rows, columns) = (all[0].rows, all[0].columns);
    let count = count.min(trees.len());
    let groups: Vec<Vec<&Tree>> = (0..count).map(|k| trees.iter().skip(k).step_by(count).collect()).collect();
    let row = |row: usize| {
        // a pixel's features side by side: trees read them in any order
        let mut pixels = vec![0.0_f32; columns * all.len()];
        for (k, feature) in all.iter().enumerate() {
            feature.row(row).iter().enumerate().for_each(|(c, v)| pixels[c * all.len() + k] = *v);
        }
        let of = |own: &Vec<&Tree>| {
            let pixels = pixels.chunks_exact(all.len());
            pixels.map(|pixel| share(own.iter().copied(), |k| pixel[k])).collect::<Vec<f32>>()
        };
        groups.iter().map(of).collect::<Vec<_>>()
    };
    let lines: Vec<Vec<Vec<f32>>> = (0..rows).into_par_iter().map(row).collect();
    let one = |k: usize| Raster {
        rows,
        columns,
        values: lines.iter().flat_map(|l| l[k].iter().copied()).collect(),
    };
    (0..count).map(one).collect()
}

fn mean(of: &[Raster]) -> Raster {
    let mut out = of[0].clone();
    for other in &of[1..] {
        out.values.iter_mut().zip(&other.values).for_each(|(a, b)| *a += b);
    }
    out.map(|v| v / of.len() as f32)
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
