//! `shadowgauge tool`: the nose of a turning tool, and what it does to a part.

mod axes;
mod bench;
mod compensate;
mod nose;
pub(super) mod overlay;
mod pictures;
mod render;
mod words;

use crate::cli::failure::CommandResult;

/// What `tool` does.
#[derive(Debug, clap::Subcommand)]
pub(crate) enum ToolCommand {
    /// How the camera's image lies in the machine, from moves of the tool along X and Z.
    Axes(axes::AxesArgs),
    /// What a worn nose leaves of a part, and a program that takes it into account.
    Compensate(compensate::CompensateArgs),
    /// The nose of a back-lit insert: both edges, their angle, centre, radii and support.
    Nose(nose::NoseArgs),
    /// Back-lit images of an insert, new or worn, with their truth.
    Render(render::RenderInsertArgs),
}

/// Runs the command.
///
/// # Errors
/// As the commands.
pub(crate) fn run(command: &ToolCommand) -> CommandResult {
    match command {
        ToolCommand::Axes(args) => axes::run(args),
        ToolCommand::Compensate(args) => compensate::run(args),
        ToolCommand::Nose(args) => nose::run(args),
        ToolCommand::Render(args) => render::run(args),
    }
}
