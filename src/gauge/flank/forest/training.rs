//! Growing trees.

use rand::seq::index::sample;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;

use super::tree::{Node, Tree};
use super::{Forest, ForestFacts};

/// Pixels with their class.
#[derive(Clone, Debug, Default)]
pub(crate) struct Samples {
    /// Features a pixel.
    pub features: usize,
    /// Values, pixel after pixel.
    pub values: Vec<f32>,
    /// Whether a pixel is land.
    pub land: Vec<bool>,
}

/// How a forest is grown.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Growth {
    /// Trees.
    pub trees: usize,
    /// Deepest node.
    pub depth: usize,
    /// Least pixels of a leaf.
    pub least_leaf: usize,
    /// Features that a split chooses from.
    pub tried: usize,
    /// Seed.
    pub seed: u64,
}

impl Default for Growth {
    /// 16 trees of at most 2^11 leaves: 0.5 MiB at most.
    fn default() -> Self {
        Self { trees: 16, depth: 11, least_leaf: 12, tried: 6, seed: 1 }
    }
}

/// Steps between which thresholds lie: quantiles of a feature's values.
const BINS: usize = 64;

/// Samples with every value as the number of its step.
struct Binned<'a> {
    samples: &'a Samples,
    steps: Vec<Vec<f32>>,
    bins: Vec<u8>,
}

/// Grows a forest: the same bytes from the same samples and seed at any number of threads.
pub(crate) fn grow(samples: &Samples, growth: &Growth) -> Forest {
    let binned = Binned::of(samples);
    let trees = (0..growth.trees).into_par_iter().map(|k| {
        let mut random = Pcg64::seed_from_u64(growth.seed.wrapping_mul(1_000_003).wrapping_add(k as u64));
        let n = samples.land.len();
        let mut pixels: Vec<u32> = (0..n).map(|_| random.random_range(0..n as u32)).collect();
        let mut tree = Tree::default();
        binned.split(&mut pixels, 0, growth, (&mut tree, &mut random));
        tree
    });
    let facts = ForestFacts { seed: growth.seed, features: samples.features, ..ForestFacts::default() };
    Forest { trees: trees.collect(), second: Vec::new(), facts }
}

impl<'a> Binned<'a> {
    fn of(samples: &'a Samples) -> Self {
        let (f, n) = (samples.features, samples.land.len());
        let steps: Vec<Vec<f32>> = (0..f)
            .map(|k| {
                let mut column: Vec<f32> = (0..n).map(|i| samples.values[i * f + k]).collect();
                column.sort_unstable_by(f32::total_cmp);
                let mut steps: Vec<f32> =
                    (1..BINS).filter_map(|b| column.get(b * n / BINS).copied()).collect();
                steps.dedup();
                steps
            })
            .collect();
        let bin = |(k, v): (usize, &f32)| steps[k % f].partition_point(|s| s <= v) as u8;
        let bins = samples.values.iter().enumerate().map(bin).collect();
        Self { samples, steps, bins }
    }

    fn bin(&self, pixel: u32, feature: usize) -> usize {
        usize::from(self.bins[pixel as usize * self.samples.features + feature])
    }

    fn split(
        &self,
        pixels: &mut [u32],
        depth: usize,
        growth: &Growth,
        (tree, random): (&mut Tree, &mut Pcg64),
    ) {
        let land = pixels.iter().filter(|p| self.samples.land[**p as usize]).count();
        let leaf = |tree: &mut Tree| {
            tree.nodes.push(Node::Leaf((land as f32 + 1.0) / (pixels.len() as f32 + 2.0)));
        };
        let pure = land == 0 || land == pixels.len();
        if depth == growth.depth || pure || pixels.len() < 2 * growth.least_leaf {
            return leaf(tree);
        }
        let tried = sample(random, self.samples.features, growth.tried.min(self.samples.features));
        let best = tried.iter().filter_map(|f| self.best(pixels, land, f, growth.least_leaf));
        let Some((_, feature, step)) = best.max_by(|a, b| a.0.total_cmp(&b.0)) else { return leaf(tree) };
        let at = tree.nodes.len();
        tree.nodes.push(Node::Leaf(0.5));
        pixels.sort_by_key(|p| self.bin(*p, feature) > step);
        let middle = pixels.partition_point(|p| self.bin(*p, feature) <= step);
        let (low, high) = pixels.split_at_mut(middle);
        self.split(low, depth + 1, growth, (tree, random));
        let other = tree.nodes.len() as u16;
        self.split(high, depth + 1, growth, (tree, random));
        tree.nodes[at] = Node::Split { feature: feature as u8, below: self.steps[feature][step], other };
    }

    /// The best split of a feature: gain, feature, last step of the smaller values.
    fn best(&self, pixels: &[u32], land: usize, feature: usize, least: usize) -> Option<(f64, usize, usize)> {
        let mut counts = [(0_u32, 0_u32); BINS];
        for p in pixels {
            let (all, of_land) = &mut counts[self.bin(*p, feature)];
            *all += 1;
            *of_land += u32::from(self.samples.land[*p as usize]);
        }
        let (n, k) = (pixels.len() as f64, land as f64);
        let (mut left, mut left_land) = (0.0, 0.0);
        let mut best: Option<(f64, usize, usize)> = None;
        for (step, (all, of_land)) in counts.iter().enumerate().take(self.steps[feature].len()) {
            left += f64::from(*all);
            left_land += f64::from(*of_land);
            let (right, right_land) = (n - left, k - left_land);
            if left < least as f64 || right < least as f64 {
                continue;
            }
            // what Gini's impurity loses, up to terms that all splits share
            let gain = (left_land.powi(2) + (left - left_land).powi(2)) / left
                + (right_land.powi(2) + (right - right_land).powi(2)) / right;
            if best.is_none_or(|b| gain > b.0) {
                best = Some((gain, feature, step));
            }
        }
        best
    }
}
