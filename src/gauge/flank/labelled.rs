//! Flanks whose land is known, pixel by pixel: what a forest is trained on, and what it is tried
//! against.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;

use super::features::{FEATURES, features};
use super::forest::Forest;
use super::forest::training::{Growth, Samples, grow};
use super::land::land;
use super::limits::FlankTrainingLimits;
use super::located::Located;
use super::raster::Raster;
use super::strip::normalised;

/// A located flank with the land of its mask.
#[derive(Clone, Debug)]
pub(crate) struct Labelled {
    /// The flank.
    pub flank: Located,
    /// 1 on land, 0 elsewhere, over the strip.
    pub land: Raster,
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

    /// Pixels drawn on both sides of the border.
    fn draw(&self, seed: u64) -> Samples {
        let mut samples = Samples { features: FEATURES, ..Samples::default() };
        let random = &mut Pcg64::seed_from_u64(seed);
        let limits = FlankTrainingLimits::get();
        let frame = &self.flank.frame;
        let all = features(&normalised(&self.flank.strip, frame), frame);
        let (columns, top) = (self.land.columns, frame.above);
        let (mut near, mut far) = (Vec::new(), Vec::new());
        for column in 0..columns {
            let land = (top..self.land.rows).rev().find(|r| self.land.at(*r, column) > 0.5);
            let last = land.map_or(top, |r| r + 1);
            let reach = last + (last - top).max(limits.near_rows);
            for row in top..(last + limits.below_rows).min(self.flank.inside[column]) {
                // between edge and border everything is land, chips and gaps of the mask too
                let pixel = (row * columns + column, row < last);
                if row < reach { near.push(pixel) } else { far.push(pixel) }
            }
        }
        for (pixels, count) in [(near, limits.pixels), (far, limits.far_pixels)] {
            if pixels.is_empty() {
                continue;
            }
            for _ in 0..count {
                let (at, land) = pixels[random.random_range(0..pixels.len())];
                samples.values.extend(all.iter().map(|f| f.values[at]));
                samples.land.push(land);
            }
        }
        samples
    }
}

/// Pixels of every flank, each drawn by the seed and its own number.
pub(crate) fn drawn(labelled: &[Labelled], seed: u64) -> Vec<Samples> {
    let one = |(k, one): (usize, &Labelled)| one.draw(seed.wrapping_mul(1_000_003).wrapping_add(k as u64));
    labelled.par_iter().enumerate().map(one).collect()
}

/// A forest from the pixels of flanks.
pub(crate) fn train<'a>(drawn: impl IntoIterator<Item = &'a Samples>, growth: &Growth) -> Forest {
    let mut samples = Samples { features: FEATURES, ..Samples::default() };
    let mut images = 0;
    for one in drawn {
        samples.values.extend_from_slice(&one.values);
        samples.land.extend_from_slice(&one.land);
        images += 1;
    }
    let mut forest = grow(&samples, growth);
    forest.facts.images = images;
    forest
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
