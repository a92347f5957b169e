//! `shadowgauge study …`: measurements over the stages.

use clap::Subcommand;

use super::CommandResult;
use super::study_deflection::{self, StudyDeflectionArgs};

/// The studies.
#[derive(Debug, Subcommand)]
pub enum Study {
    /// Compliance of a held shaft over the position of a radial load.
    Deflection(StudyDeflectionArgs),
}

/// Runs a study.
///
/// # Errors
/// As the study.
pub fn run(study: &Study) -> CommandResult {
    match study {
        Study::Deflection(args) => study_deflection::run(args),
    }
}
