//! `shadowgauge study …`: measurements over the stages.
//!
//! A study has a file here with its arguments, its config and its output, and one in `studies` with
//! the computation. A new one is such a pair, its `mod` line and a variant of [`Study`].

mod contamination;
mod controllers;
mod correlation;
mod coverage;
mod deflection;
mod factor;
mod flank;
mod head;
mod in_process;
mod limits;
mod line_camera;
mod machine;
mod machine_coverage;
mod machine_models;
mod merge;
mod nose;
mod nose_frames;
mod optics;
mod parts;
mod shard;
mod stability;
mod tool;
mod uncertainty;
pub(crate) mod unsplit;
mod washers;

use clap::Subcommand;

use self::contamination::StudyContaminationArgs;
use self::controllers::StudyControllersArgs;
use self::correlation::StudyCorrelationArgs;
use self::coverage::StudyCoverageArgs;
use self::deflection::StudyDeflectionArgs;
use self::factor::StudyFactorArgs;
use self::flank::StudyFlankArgs;
use self::head::StudyHeadArgs;
use self::in_process::StudyInProcessArgs;
use self::limits::StudyLimitsArgs;
use self::line_camera::StudyLineCameraArgs;
use self::machine::StudyMachineArgs;
use self::machine_coverage::StudyMachineCoverageArgs;
use self::merge::StudyMergeArgs;
use self::nose::StudyNoseArgs;
use self::optics::StudyOpticsArgs;
use self::parts::StudyPartsArgs;
use self::stability::StudyStabilityArgs;
use self::tool::StudyToolArgs;
use self::uncertainty::StudyUncertaintyArgs;
use self::washers::StudyWashersArgs;
use crate::cli::failure::CommandResult;

/// The studies.
#[derive(Debug, Subcommand)]
pub(crate) enum Study {
    /// Compliance of a held shaft over the position of a radial load.
    Deflection(StudyDeflectionArgs),
    /// Contamination before the shaft and on it: how often it misleads the gauge.
    Contamination(StudyContaminationArgs),
    /// Every controller on the same shafts, through rendered and measured frames.
    Controllers(StudyControllersArgs),
    /// A batch of parts, with and without learning from part to part.
    Parts(StudyPartsArgs),
    /// Stability of every controller with every plant.
    Stability(StudyStabilityArgs),
    /// One job scanned after every pass and while it is cut, with and without correction within the
    /// pass.
    InProcess(StudyInProcessArgs),
    /// Edges a second and repeatability of a line camera's readings, beside its rate and the bound.
    LineCamera(StudyLineCameraArgs),
    /// The 21 errors of a lathe over its working space, their budget, and what heads make of them.
    Machine(StudyMachineArgs),
    /// Whether the uncertainty of an identified machine holds, over machines drawn of its class.
    MachineCoverage(StudyMachineCoverageArgs),
    /// Noses of rendered inserts, measured: errors beside their stated uncertainties, by kind of
    /// wear.
    Nose(StudyNoseArgs),
    /// What moves the edge of a round part before one head, and by how much: focus, apertures,
    /// wavelength, diameter, material, film, finish, temperature.
    Optics(StudyOpticsArgs),
    /// Flanks that are drawn, measured: errors beside their stated uncertainties.
    Flank(StudyFlankArgs),
    /// Four workpieces cut by a worn nose that is measured in an image, before and after every way
    /// to compensate, beside paper 004.
    Tool(StudyToolArgs),
    /// One cutting variable at a time against the size error.
    Factor(StudyFactorArgs),
    /// What heads will measure a part to, and how fast, from their configs alone: side by side.
    Head(StudyHeadArgs),
    /// This gauge's readings of parts beside another's: E_n of each, and the line with both
    /// uncertain.
    Correlation(StudyCorrelationArgs),
    /// Whether stated intervals cover the true diameters, in rendered and measured scenes.
    Coverage(StudyCoverageArgs),
    /// Monte Carlo (JCGM 101) beside the law of propagation, through calibration and measurement.
    Uncertainty(StudyUncertaintyArgs),
    /// Half and double of every threshold of the instrument: what each changes on the same scenes.
    Limits(StudyLimitsArgs),
    /// Join the shards of a study that was split by --shard, and print what it prints unsplit.
    Merge(StudyMergeArgs),
    /// Rings of known size, leave-one-out, beside a level crossing.
    Washers(StudyWashersArgs),
}

/// Runs a study.
///
/// # Errors
/// As the study.
pub(crate) fn run(study: &Study) -> CommandResult {
    match study {
        Study::Deflection(args) => deflection::run(args),
        Study::Contamination(args) => contamination::run(args),
        Study::Controllers(args) => controllers::run(args),
        Study::Parts(args) => parts::run(args),
        Study::Stability(args) => stability::run(args),
        Study::Correlation(args) => correlation::run(args),
        Study::Coverage(args) => coverage::run(args),
        Study::Uncertainty(args) => uncertainty::run(args),
        Study::Washers(args) => washers::run(args),
        Study::InProcess(args) => in_process::run(args),
        Study::LineCamera(args) => line_camera::run(args),
        Study::Machine(args) => machine::run(args),
        Study::MachineCoverage(args) => machine_coverage::run(args),
        Study::Nose(args) => nose::run(args),
        Study::Optics(args) => optics::run(args),
        Study::Tool(args) => tool::run(args),
        Study::Flank(args) => flank::run(args),
        Study::Factor(args) => factor::run(args),
        Study::Head(args) => head::run(args),
        Study::Limits(args) => limits::run(args),
        Study::Merge(args) => merge::run(args),
    }
}
