//! The scenes of a study by their numbers, and its result from their outcomes.

use serde::{Deserialize, Serialize};

use super::class::Class;
use super::figures::{ClassFigures, figures, scene_seed};
use super::outcome::Outcome;
use super::scene;
use super::verdict::Coverage;
use crate::render::{BackendChoice, Renderer};
use crate::studies::calibration::CalibrateError;
use crate::studies::sharding::{Cell, ColumnKind, Columns, SceneStudy};

/// Shares of the scenes: all for the drawn classes, less for the others.
const GROUPS: [(&[Class], usize); 5] = [
    (&Class::DRAWN, 1),
    (&Class::DEVIATING, 3),
    (&Class::LIMBS, 2),
    (&Class::DETECTABLE, 6),
    (&Class::UNDETECTABLE, 12),
];

/// What is drawn.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CoveragePlan {
    /// Scenes drawn from the budget's own distributions, or of each class that is asked for.
    pub scenes: usize,
    /// Seed of the draws.
    pub seed: u64,
    /// Only these classes; empty for the whole study.
    pub only: Vec<Class>,
}

/// What it gives.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum CoverageResult {
    /// The whole study.
    Whole(Box<Coverage>),
    /// The classes that were asked for, without a verdict.
    Only(Vec<ClassFigures>),
}

impl CoveragePlan {
    /// The classes in the order of their scenes, with the number of scenes of each.
    fn counts(&self) -> Vec<(Class, usize)> {
        if !self.only.is_empty() {
            return self.only.iter().map(|class| (*class, self.scenes)).collect();
        }
        let of = |(classes, share): &(&[Class], usize)| {
            let each = (self.scenes / share).div_ceil(classes.len());
            classes.iter().map(|class| (*class, each)).collect::<Vec<_>>()
        };
        GROUPS.iter().flat_map(of).collect()
    }

    /// Class and index in it of a scene.
    fn place(&self, number: u64) -> Option<(Class, u64)> {
        let mut index = number;
        for (class, count) in self.counts() {
            match index.checked_sub(count as u64) {
                Some(beyond) => index = beyond,
                None => return Some((class, index)),
            }
        }
        None
    }

    /// The figures of all scenes' outcomes in their order.
    pub(crate) fn result(&self, outcomes: &[Outcome]) -> CoverageResult {
        let mut rest = outcomes;
        let mut next = |count: usize| {
            let (own, others) = rest.split_at(count.min(rest.len()));
            rest = others;
            own
        };
        if !self.only.is_empty() {
            let of = |class: &Class| figures(Some(*class), next(self.scenes));
            return CoverageResult::Only(self.only.iter().map(of).collect());
        }
        let mut group = |(classes, share): (&[Class], usize)| {
            let each = (self.scenes / share).div_ceil(classes.len());
            let own = next(each * classes.len());
            let of = |(i, class): (usize, &Class)| {
                figures(Some(*class), own.get(i * each..(i + 1) * each).unwrap_or_default())
            };
            (classes.iter().enumerate().map(of).collect::<Vec<_>>(), figures(None, own))
        };
        let [of_drawn, of_deviating, of_limbs, of_detectable, of_undetectable] = GROUPS;
        let (drawn, drawn_together) = group(of_drawn);
        let (deviating, deviating_together) = group(of_deviating);
        let (limbs, limbs_together) = group(of_limbs);
        let (detectable, _) = group(of_detectable);
        let (undetectable, _) = group(of_undetectable);
        CoverageResult::Whole(Box::new(Coverage {
            drawn,
            drawn_together,
            deviating,
            deviating_together,
            limbs,
            limbs_together,
            detectable,
            undetectable,
        }))
    }
}

impl SceneStudy for CoveragePlan {
    const NAME: &'static str = "coverage";
    const COLUMNS: Columns = &[
        ("error_mm", ColumnKind::Double),
        ("u_mm", ColumnKind::Double),
        ("half_width_mm", ColumnKind::Double),
        ("flag", ColumnKind::Text),
    ];
    type Outcome = Outcome;
    type Bench = Renderer;
    type Error = CalibrateError;

    fn seed(&self) -> u64 {
        self.seed
    }

    fn scenes(&self) -> u64 {
        self.counts().iter().map(|(_, count)| *count as u64).sum()
    }

    fn bench(&self) -> Result<Renderer, CalibrateError> {
        Ok(Renderer::new(BackendChoice::Cpu)?)
    }

    fn scene(&self, number: u64, renderer: &Renderer) -> Result<Outcome, CalibrateError> {
        let (class, index) = self.place(number).unwrap_or((Class::Mixed, number));
        scene::run(class, scene_seed(class, self.seed, index), renderer)
    }

    fn row(outcome: &Outcome) -> Vec<Cell> {
        vec![
            Cell::Double(outcome.error_mm),
            Cell::Double(Some(outcome.u_mm)),
            Cell::Double(Some(outcome.half_mm)),
            Cell::Text(outcome.flag.clone()),
        ]
    }

    fn outcome(row: &[Cell]) -> Option<Outcome> {
        match row {
            [
                Cell::Double(error_mm),
                Cell::Double(Some(u_mm)),
                Cell::Double(Some(half_mm)),
                Cell::Text(flag),
            ] => Some(Outcome { error_mm: *error_mm, u_mm: *u_mm, half_mm: *half_mm, flag: flag.clone() }),
            _ => None,
        }
    }
}
