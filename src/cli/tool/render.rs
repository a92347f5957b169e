//! `shadowgauge tool render`: back-lit images of an insert, with what is true of it.

use std::path::PathBuf;

use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::{ConfigText, StudyFolder, json_text};
use crate::cli::render::frame_files::{FileFormat, encode};
use crate::render::insert::{InsertSettings, render_insert};

/// Arguments of `tool render`.
#[derive(Debug, clap::Args)]
pub(crate) struct RenderInsertArgs {
    /// A TOML file with the insert, its wear and the camera (`schema insert`).
    config: PathBuf,
    /// Folder for `frames/000000.png`, … (16-bit grey PNG) and `truth.json`.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Frames, which differ by their noise.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=1000))]
    frames: u64,
    /// Seed of the noise.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Without temporal noise.
    #[arg(long)]
    no_noise: bool,
}

/// Runs the command.
///
/// # Errors
/// Exit 2 for a config that is refused, or a folder that is taken.
pub(crate) fn run(args: &RenderInsertArgs) -> CommandResult {
    let text = ConfigText::read(&args.config)?;
    let settings: InsertSettings = text.parse()?;
    settings.check().map_err(|e| text.refuse(e))?;
    let folder = StudyFolder::claim(Some(&args.out))?;
    StudyFolder::fill(folder, |folder| {
        for number in 0..args.frames {
            let drawn = render_insert(&settings, (args.seed, number), !args.no_noise);
            let (frame, truth) = drawn.map_err(|e| text.refuse(e))?;
            let file = encode(&frame, FileFormat::Png16, settings.camera.um_per_px).map_err(Failure::fail)?;
            folder.write(&format!("frames/{number:06}.png"), &file)?;
            if number == 0 {
                folder.write("truth.json", (json_text(&truth)? + "\n").as_bytes())?;
            }
        }
        Ok(())
    })?;
    Ok(Outcome::Done)
}
