//! `shadowgauge study …`: measurements over the stages.

use clap::Subcommand;

use super::CommandResult;
use super::study_controllers::{self, StudyControllersArgs};
use super::study_deflection::{self, StudyDeflectionArgs};
use super::study_factor::{self, StudyFactorArgs};
use super::study_parts::{self, StudyPartsArgs};
use super::study_stability::{self, StudyStabilityArgs};

/// The studies.
#[derive(Debug, Subcommand)]
pub enum Study {
    /// Compliance of a held shaft over the position of a radial load.
    Deflection(StudyDeflectionArgs),
    /// Every controller on the same shafts, through rendered and measured frames.
    Controllers(StudyControllersArgs),
    /// A batch of parts, with and without learning from part to part.
    Parts(StudyPartsArgs),
    /// Stability of every controller with every plant.
    Stability(StudyStabilityArgs),
    /// One cutting variable at a time against the size error.
    Factor(StudyFactorArgs),
}

/// Runs a study.
///
/// # Errors
/// As the study.
pub fn run(study: &Study) -> CommandResult {
    match study {
        Study::Deflection(args) => study_deflection::run(args),
        Study::Controllers(args) => study_controllers::run(args),
        Study::Parts(args) => study_parts::run(args),
        Study::Stability(args) => study_stability::run(args),
        Study::Factor(args) => study_factor::run(args),
    }
}
