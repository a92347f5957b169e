//! `shadowgauge optics …`: what a config's optics do to an edge, as tables that other commands
//! read.

mod esf;
mod head_config;
mod limb;

pub(crate) use self::esf::NominalOptics;
pub(crate) use self::head_config::{head_failure, load_head};
pub(crate) use self::limb::fitted_by;
use self::{esf::EsfArgs, limb::LimbArgs};
use crate::cli::failure::CommandResult;

/// What `optics` shows.
#[derive(Debug, clap::Subcommand)]
pub(crate) enum OpticsCommand {
    /// Light over the distance from the geometric edge, as `--esf FILE` reads it.
    Esf(EsfArgs),
    /// How far the edges of a part stand from where the masters' calibration places them, as
    /// `--conditions FILE` reads it.
    Limb(LimbArgs),
}

/// Runs the command.
///
/// # Errors
/// Exit 2 for a config or optics that are refused.
pub(crate) fn run(command: &OpticsCommand) -> CommandResult {
    match command {
        OpticsCommand::Esf(args) => esf::run(args),
        OpticsCommand::Limb(args) => limb::run(args),
    }
}
