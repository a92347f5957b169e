//! `shadowgauge calibrate`: an optical setup by its config; with `machine` the geometric errors of
//! a lathe.

#[cfg(feature = "camera")]
mod asked;
#[cfg(feature = "camera")]
mod asked_camera;
mod camera_args;
#[cfg(feature = "camera")]
mod camera_frames;
mod fit_esf;
mod machine;
mod machine_tables;
mod machine_words;
mod optical_setup;
mod recorded_frames;
mod said;

use super::failure::CommandResult;
pub(crate) use optical_setup::make;

/// Arguments of `calibrate`.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(crate) struct CalibrateArgs {
    #[command(flatten)]
    optical_setup: optical_setup::OpticalSetupArgs,
    #[command(subcommand)]
    other: Option<CalibrateCommand>,
}

/// What else is calibrated.
#[derive(Debug, clap::Subcommand)]
enum CalibrateCommand {
    /// Identify a lathe's geometric errors from readings, for the compensation.
    Machine(machine::CalibrateMachineArgs),
}

/// Runs the command.
///
/// # Errors
/// As the commands.
pub(crate) fn run(args: &CalibrateArgs) -> CommandResult {
    match &args.other {
        Some(CalibrateCommand::Machine(args)) => machine::run(args),
        None => optical_setup::run(&args.optical_setup),
    }
}
