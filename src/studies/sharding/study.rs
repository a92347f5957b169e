//! The interface of a study of independent scenes, and its scenes on threads.

use std::fmt::Display;

use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::cell::{Cell, Columns};

/// A study whose scenes are independent: each follows from the study's settings, which serialise
/// to JSON and hold the seed, and from its number alone.
pub(crate) trait SceneStudy: Serialize + DeserializeOwned + Sync {
    /// Name as on the command line.
    const NAME: &'static str;
    /// Columns of an outcome; `scene`, its number, stands before them.
    const COLUMNS: Columns;
    /// What a scene yields.
    type Outcome: Send;
    /// What all scenes share: a renderer, a gauge.
    type Bench: Sync;
    /// Why a scene has no outcome.
    type Error: Display + Send;

    /// Seed of the study.
    fn seed(&self) -> u64;

    /// Number of its scenes.
    fn scenes(&self) -> u64;

    /// What its scenes share.
    ///
    /// # Errors
    /// Where it cannot be set up.
    fn bench(&self) -> Result<Self::Bench, Self::Error>;

    /// The outcome of scene `number`, below [`Self::scenes`].
    ///
    /// # Errors
    /// A scene that cannot be drawn or measured.
    fn scene(&self, number: u64, bench: &Self::Bench) -> Result<Self::Outcome, Self::Error>;

    /// A row of a table, by [`Self::COLUMNS`].
    fn row(outcome: &Self::Outcome) -> Vec<Cell>;

    /// The outcome of a row; `None` where it does not follow [`Self::COLUMNS`].
    fn outcome(row: &[Cell]) -> Option<Self::Outcome>;
}

/// Outcomes of scenes by their numbers, in their order, on all threads; `done` is called after
/// each.
///
/// # Errors
/// The first scene without an outcome.
pub(crate) fn outcomes<S: SceneStudy>(
    study: &S,
    bench: &S::Bench,
    scenes: impl Iterator<Item = u64>,
    done: &(dyn Fn() + Sync),
) -> Result<Vec<S::Outcome>, S::Error> {
    let scenes: Vec<u64> = scenes.collect();
    let outcome = |number: u64| study.scene(number, bench).inspect(|_| done());
    scenes.into_par_iter().map(outcome).collect()
}
