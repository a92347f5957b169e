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
    /// The trees.
    pub trees: Vec<Tree>,
    /// What it states of itself.
    pub facts: ForestFacts,
}

impl Forest {
    /// Probability that a pixel with these features is land.
    pub(crate) fn probability(&self, feature: impl Fn(usize) -> f32 + Copy) -> f32 {
        let sum: f32 = self.trees.iter().map(|tree| tree.share(feature)).sum();
        sum / self.trees.len().max(1) as f32
    }

    /// The trees dealt out to so many forests, whose disagreement is part of the model's
    /// uncertainty; of fewer trees a tree a group.
    pub(crate) fn groups(&self, count: usize) -> Vec<Self> {
        let group =
            |k: usize| self.trees.iter().skip(k).step_by(count.max(1)).cloned().collect::<Vec<Tree>>();
        (0..count.min(self.trees.len()))
            .map(|k| Self { trees: group(k), facts: self.facts.clone() })
            .collect()
    }
}
