//! `shadowgauge tool`: nose and flank of a turning tool, and what they do to a part.

mod axes;
mod bench;
mod canvas;
mod compensate;
pub(super) mod flank;
pub(super) mod nose;
pub(super) mod overlay;
mod pictures;
mod render;
pub(super) mod render_flank;
mod strips;
mod train;
mod words;

use crate::cli::failure::CommandResult;

/// What `tool` does.
#[derive(Debug, clap::Subcommand)]
pub(crate) enum ToolCommand {
    /// How the camera's image lies in the machine, from moves of the tool along X and Z.
    Axes(axes::AxesArgs),
    /// What a worn nose leaves of a part, and a program that takes it into account.
    Compensate(compensate::CompensateArgs),
    /// The worn land of front-lit flanks: VBB, VBBmax, VC, VN by ISO 3685, and whether the edge is
    /// blunt.
    Flank(flank::FlankArgs),
    /// The nose of a back-lit insert: both edges, their angle, centre, radii and support.
    Nose(nose::NoseArgs),
    /// Back-lit images of an insert, new or worn, with their truth.
    Render(render::RenderInsertArgs),
    /// Front-lit images of worn flanks, with mask and truth.
    RenderFlank(render_flank::RenderFlankArgs),
    /// A model for `tool flank` from flanks whose land was drawn by hand.
    Train(train::TrainArgs),
}

/// Runs the command.
///
/// # Errors
/// As the commands.
pub(crate) fn run(command: &ToolCommand) -> CommandResult {
    match command {
        ToolCommand::Axes(args) => axes::run(args),
        ToolCommand::Compensate(args) => compensate::run(args),
        ToolCommand::Flank(args) => flank::run(args),
        ToolCommand::Nose(args) => nose::run(args),
        ToolCommand::Render(args) => render::run(args),
        ToolCommand::RenderFlank(args) => render_flank::run(args),
        ToolCommand::Train(args) => train::run(args),
    }
}
