//! `shadowgauge study …`: measurements over the stages.

use clap::Subcommand;

use super::CommandResult;
use super::study_contamination::{self, StudyContaminationArgs};
use super::study_controllers::{self, StudyControllersArgs};
use super::study_coverage::{self, StudyCoverageArgs};
use super::study_deflection::{self, StudyDeflectionArgs};
use super::study_factor::{self, StudyFactorArgs};
use super::study_in_process::{self, StudyInProcessArgs};
use super::study_line_camera::{self, StudyLineCameraArgs};
use super::study_parts::{self, StudyPartsArgs};
use super::study_stability::{self, StudyStabilityArgs};
use super::study_uncertainty::{self, StudyUncertaintyArgs};
use super::study_washers::{self, StudyWashersArgs};

/// The studies.
#[derive(Debug, Subcommand)]
pub enum Study {
    /// Compliance of a held shaft over the position of a radial load.
    Deflection(StudyDeflectionArgs),
    /// Matter before the shaft and on it: how often it misleads the gauge.
    Contamination(StudyContaminationArgs),
    /// Every controller on the same shafts, through rendered and measured frames.
    Controllers(StudyControllersArgs),
    /// A batch of parts, with and without learning from part to part.
    Parts(StudyPartsArgs),
    /// Stability of every controller with every plant.
    Stability(StudyStabilityArgs),
    /// One job scanned after every pass and while it is cut, with and without correction within the pass.
    InProcess(StudyInProcessArgs),
    /// Edges a second and repeatability of a line camera's readings, beside its rate and the bound.
    LineCamera(StudyLineCameraArgs),
    /// One cutting variable at a time against the size error.
    Factor(StudyFactorArgs),
    /// Whether stated intervals cover the true diameters, in rendered and measured scenes.
    Coverage(StudyCoverageArgs),
    /// Monte Carlo (JCGM 101) beside the law of propagation, through calibration and measurement.
    Uncertainty(StudyUncertaintyArgs),
    /// Rings of known size, leave-one-out, beside a level crossing.
    Washers(StudyWashersArgs),
}

/// Runs a study.
///
/// # Errors
/// As the study.
pub fn run(study: &Study) -> CommandResult {
    match study {
        Study::Deflection(args) => study_deflection::run(args),
        Study::Contamination(args) => study_contamination::run(args),
        Study::Controllers(args) => study_controllers::run(args),
        Study::Parts(args) => study_parts::run(args),
        Study::Stability(args) => study_stability::run(args),
        Study::Coverage(args) => study_coverage::run(args),
        Study::Uncertainty(args) => study_uncertainty::run(args),
        Study::Washers(args) => study_washers::run(args),
        Study::InProcess(args) => study_in_process::run(args),
        Study::LineCamera(args) => study_line_camera::run(args),
        Study::Factor(args) => study_factor::run(args),
    }
}
