//! A forest of decision trees: features of a pixel to the probability that it is worn land.
//!
//! Breiman (2001): every tree on a bootstrap sample, every split the best of a random few features
//! by Gini's impurity, leaves with the share of land in them. `tree` is one, `training` grows
//! them, `file` is their file (at most 1 MiB).

pub(crate) mod file;
pub(crate) mod training;
pub(crate) mod tree;

use tree::Tree;

/// What a forest states of itself.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub(crate) struct ForestFacts {
    /// What it was trained on, in words.
    pub trained_on: String,
    /// Images.
    pub images: usize,
    /// Seed.
    pub seed: u64,
    /// Features a pixel.
    pub features: usize,
    /// Root mean square of the error of VB over images that were left out of the training, µm.
    pub vb_error_um: f64,
    /// The same of VBmax, µm.
    pub vb_max_error_um: f64,
}

/// Trees that vote by their mean.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Forest {
    /// The first trees, which see a pixel's features.
    pub trees: Vec<Tree>,
    /// The second trees, which see beside them what the first found about the pixel; none in a
    /// forest of one stage.
    pub second: Vec<Tree>,
    /// What it states of itself.
    pub facts: ForestFacts,
}

impl Forest {
    /// Probability of the first trees that a pixel with these features is land.
    #[cfg(test)]
    pub(crate) fn probability(&self, feature: impl Fn(usize) -> f32 + Copy) -> f32 {
        share(self.trees.iter(), feature)
    }
}

/// Mean share of land by some trees.
pub(crate) fn share<'a>(
    trees: impl ExactSizeIterator<Item = &'a Tree>,
    feature: impl Fn(usize) -> f32 + Copy,
) -> f32 {
    let count = trees.len().max(1) as f32;
    trees.map(|tree| tree.share(feature)).sum::<f32>() / count
}
