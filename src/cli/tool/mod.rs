//! `shadowgauge tool`: the nose of a turning tool, and what it does to a part.

mod compensate;
mod pictures;
mod words;

use crate::cli::failure::CommandResult;

/// What `tool` does.
#[derive(Debug, clap::Subcommand)]
pub(crate) enum ToolCommand {
    /// What a worn nose leaves of a part, and a program that takes it into account.
    Compensate(compensate::CompensateArgs),
}

/// Runs the command.
///
/// # Errors
/// As the commands.
pub(crate) fn run(command: &ToolCommand) -> CommandResult {
    let ToolCommand::Compensate(args) = command;
    compensate::run(args)
}
