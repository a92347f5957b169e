//! Whether the stated intervals cover the true diameters: scenes drawn from the budget's own
//! distributions, round parts drawn from the rows of their limbs, scenes that deviate inside the
//! declared limits, scenes outside them.
//!
//! `class` declares the classes of scenes, `scene` draws and measures one (`illumination`, `limb`:
//! its light and its surface), `plan` numbers the scenes of a study, which can be split into
//! shards, `figures` are those of a class, `verdict` what the study requires of them.

mod class;
mod figures;
mod illumination;
mod limb;
mod outcome;
mod plan;
mod scene;
mod verdict;

pub(crate) use class::Class;
pub(crate) use figures::{ClassFigures, class_figures};
pub(crate) use outcome::Outcome;
pub(crate) use plan::{CoveragePlan, CoverageResult};
pub(in crate::studies) use scene::{Recorded, measure, record};
pub(crate) use verdict::Coverage;
