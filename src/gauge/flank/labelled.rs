//! Flanks whose land is known, pixel by pixel: what a forest is trained on, and what it is tried
//! against.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;

use super::context::CONTEXT;
use super::features::{FEATURES, features};
use super::forest::Forest;
use super::forest::training::{Growth, Samples, grow};
use super::forest::tree::Tree;
use super::land::{below, first_context, land};
use super::limits::FlankTrainingLimits;
use super::located::Located;
use super::raster::{Raster, quantile};
use super::strip::normalised;

/// A located flank with the land of its mask.
#[derive(Clone, Debug)]
pub(crate) struct Labelled {
    /// The flank.
    pub flank: Located,
    /// 1 on land, 0 elsewhere, over the strip.
    pub land: Raster,
}

/// Pixels of a flank at one of its scales, and what the second trees are trained by.
#[derive(Clone, Debug)]
pub(crate) struct Drawn {
    /// The pixels with their features.
    samples: Samples,
    /// Their places below the reference, row after row.
    places: Vec<usize>,
    /// The flank, whose features are computed anew: all of them would fill the memory.
    flank: Located,
}

impl Labelled {
    /// From a mask over the whole image (0 none, 1 land).
    pub(crate) fn new(flank: Located, mask: &Raster) -> Self {
        let (land, _) = flank.frame.cut(mask);
        Self { flank, land: land.map(|v| f32::from(u8::from(v >= 0.5))) }
    }

    /// Width of the mask in every column, µm.
    pub(crate) fn width_um(&self) -> Vec<f64> {
        let frame = &self.flank.frame;
        let sum = |c: usize| (0..self.land.rows).map(|r| f64::from(self.land.at(r, c))).sum::<f64>();
        (0..self.land.columns).map(|c| sum(c) * frame.row_um()).collect()
    }

    /// Median distance of the mask's upper border from the reference, µm; none without a mask.
    pub(crate) fn off_edge_um(&self) -> Option<f64> {
        let first = |c: usize| (0..self.land.rows).find(|r| self.land.at(*r, c) > 0.5);
        let tops: Vec<f32> =
            (0..self.land.columns).filter_map(first).map(|r| self.flank.frame.depth_um(r) as f32).collect();
        (!tops.is_empty()).then(|| f64::from(quantile(tops, 0.5)))
    }

    /// The same flank as if its structures were `1/by` as large: lands are alike at any width.
    fn scaled(&self, by: f64) -> Self {
        let frame = &self.flank.frame;
        let (rows, columns) = (self.land.rows, ((self.land.columns - 1) as f64 / by) as usize + 1);
        let of = |from: &Raster| {
            let mut out = Raster::new(rows, columns);
            for row in 0..rows {
                let source = frame.above as f64 + (row as f64 - frame.above as f64) * by;
                let source = source.clamp(0.0, (rows - 1) as f64);
                for column in 0..columns {
                    let along = (column as f64 * by).min((from.columns - 1) as f64);
                    out.values[row * columns + column] = from.between(source, along).unwrap_or_default();
                }
            }
            out
        };
        let inside = |c: usize| {
            let limit = self.flank.inside[((c as f64 * by) as usize).min(self.flank.inside.len() - 1)];
            let below = (limit.saturating_sub(frame.above) as f64 / by) as usize;
            (frame.above + below).min(rows)
        };
        let mut flank = self.flank.clone();
        flank.strip = of(&self.flank.strip);
        flank.inside = (0..columns).map(inside).collect();
        Self { flank, land: of(&self.land).map(|v| f32::from(u8::from(v >= 0.5))) }
    }

    /// Pixels drawn on both sides of the border, so many for each that the limits state.
    fn draw(&self, seed: u64, share: f64) -> Drawn {
        let mut samples = Samples { features: FEATURES, ..Samples::default() };
        let random = &mut Pcg64::seed_from_u64(seed);
        let limits = FlankTrainingLimits::get();
        let frame = &self.flank.frame;
        let all = pixel_features(&self.flank);
        let (columns, top) = (self.land.columns, frame.above);
        let (mut near, mut far) = (Vec::new(), Vec::new());
        for column in 0..columns {
            let land = (top..self.land.rows).rev().find(|r| self.land.at(*r, column) > 0.5);
            let last = land.map_or(top, |r| r + 1);
            let reach = last + (last - top).max(limits.near_rows);
            for row in top..(last + limits.below_rows).min(self.flank.inside[column]) {
                // between edge and border everything is land, chips and gaps of the mask too
                let pixel = ((row - top) * columns + column, row < last);
                if row < reach { near.push(pixel) } else { far.push(pixel) }
            }
        }
        let mut places = Vec::new();
        for (pixels, count) in [(near, limits.pixels), (far, limits.far_pixels)] {
            if pixels.is_empty() {
                continue;
            }
            for _ in 0..(count as f64 * share) as usize {
                let (at, land) = pixels[random.random_range(0..pixels.len())];
                samples.values.extend(all.iter().map(|f| f.values[at]));
                samples.land.push(land);
                places.push(at);
            }
        }
        Drawn { samples, places, flank: self.flank.clone() }
    }
}

/// Features of every pixel below the reference.
fn pixel_features(flank: &Located) -> Vec<Raster> {
    below(&features(&normalised(&flank.strip, &flank.frame), &flank.frame), &flank.frame)
}

impl Drawn {
    /// The samples with what trees that have not seen this flank find about them.
    fn with_context(&self, trees: &[Tree]) -> Samples {
        let flank = &self.flank;
        let context = first_context(&pixel_features(flank), &flank.frame, &flank.inside, trees);
        let mut out = Samples { features: FEATURES + CONTEXT, ..Samples::default() };
        for (k, at) in self.places.iter().enumerate() {
            out.values.extend_from_slice(&self.samples.values[k * FEATURES..(k + 1) * FEATURES]);
            out.values.extend(context.iter().map(|f| f.values[*at]));
        }
        out.land.clone_from(&self.samples.land);
        out
    }
}

/// Pixels of every flank at several scales, each drawn by the seed and its own number.
pub(crate) fn drawn(labelled: &[Labelled], seed: u64) -> Vec<Vec<Drawn>> {
    let limits = FlankTrainingLimits::get();
    let scales = limits.scales(labelled.len());
    let share = limits.share(labelled.len()) / scales.len() as f64;
    let one = |(k, one): (usize, &Labelled)| {
        let seed = seed.wrapping_mul(1_000_003).wrapping_add(k as u64);
        let at = |(i, by): (usize, &f64)| {
            let seed = seed.wrapping_add((i as u64) << 32);
            if *by == 1.0 { one.draw(seed, share) } else { one.scaled(*by).draw(seed, share) }
        };
        scales.iter().enumerate().map(at).collect()
    };
    labelled.par_iter().enumerate().map(one).collect()
}

/// A forest from the pixels of flanks: first trees, and second ones which see what first trees
/// found that were grown on other flanks.
pub(crate) fn train<'a>(drawn: impl IntoIterator<Item = &'a Vec<Drawn>>, growth: &Growth) -> Forest {
    let drawn: Vec<&Vec<Drawn>> = drawn.into_iter().collect();
    let parts = FlankTrainingLimits::get().folds;
    let first = |skip: Option<usize>| {
        let kept = drawn.iter().enumerate().filter(|(k, _)| skip.is_none_or(|s| k % parts != s));
        let samples = kept.flat_map(|(_, d)| d.iter().map(|d| d.samples.clone()));
        grow(&joined(samples, FEATURES), growth)
    };
    let folds: Vec<Forest> = (0..parts).map(|fold| first(Some(fold))).collect();
    let with = |(k, scales): (usize, &&Vec<Drawn>)| {
        let trees = &folds[k % parts].trees;
        scales.iter().map(|d| d.with_context(trees)).collect::<Vec<_>>()
    };
    let context: Vec<Vec<Samples>> = drawn.par_iter().enumerate().map(with).collect();
    let mut forest = first(None);
    forest.second = grow(&joined(context.into_iter().flatten(), FEATURES + CONTEXT), growth).trees;
    forest.facts.images = drawn.len();
    forest
}

fn joined(parts: impl Iterator<Item = Samples>, features: usize) -> Samples {
    let mut samples = Samples { features, ..Samples::default() };
    for one in parts {
        samples.values.extend_from_slice(&one.values);
        samples.land.extend_from_slice(&one.land);
    }
    samples
}

/// Errors of VB and VBmax of a forest on a labelled flank, µm, over the worn length of its mask.
pub(crate) fn errors_um(forest: &Forest, one: &Labelled) -> (f64, f64) {
    let found = land(&one.flank.strip, &one.flank.frame, &one.flank.inside, forest);
    let truth = one.width_um();
    let over: Vec<usize> = (0..truth.len()).filter(|k| truth[*k] > 0.0).collect();
    let mean = |values: &[f64]| over.iter().map(|k| values[*k]).sum::<f64>() / over.len().max(1) as f64;
    let largest = |values: &[f64]| over.iter().map(|k| values[*k]).fold(0.0, f64::max);
    (mean(&found.depth_um) - mean(&truth), largest(&found.depth_um) - largest(&truth))
}
