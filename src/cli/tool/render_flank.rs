//! `shadowgauge tool render-flank`: front-lit images of worn flanks, with their truth.

use std::path::PathBuf;

use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::{ConfigText, StudyFolder, json_text};
use crate::cli::render::frame_files::{FileFormat, encode, write_grey};
use crate::cli::tool::nose::scale;
use crate::render::flank::{FlankScene, render_flank};

/// Arguments of `tool render-flank`.
#[derive(Debug, clap::Args)]
pub(crate) struct RenderFlankArgs {
    /// A TOML file with the flank, its wear and the camera (`schema flank`).
    #[arg(required_unless_present = "random", conflicts_with = "random")]
    config: Option<PathBuf>,
    /// Draw so many scenes at random instead.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10_000))]
    random: Option<u64>,
    /// Size of the random scenes.
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "900x560", value_parser = size)]
    size: (u32, u32),
    /// Scale of the random scenes, µm per px.
    #[arg(long, value_name = "S", default_value_t = 2.415, value_parser = scale)]
    um_per_px: f64,
    /// Folder for `000000.png`, `000000_land.png`, `000000_truth.json`, …
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Seed of surfaces and noise.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

/// A size as `900x560`.
pub(crate) fn size(text: &str) -> Result<(u32, u32), String> {
    let parsed = text.split_once('x').and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    parsed.ok_or_else(|| "a size as 900x560 is needed".to_owned())
}

/// Runs the command.
///
/// # Errors
/// Exit 2 for a config that is refused, or a folder that is taken.
pub(crate) fn run(args: &RenderFlankArgs) -> CommandResult {
    let of_file = match &args.config {
        Some(path) => {
            let text = ConfigText::read(path)?;
            let scene: FlankScene = text.parse()?;
            scene.check().map_err(|e| text.refuse(e))?;
            Some(scene)
        }
        None => None,
    };
    let folder = StudyFolder::claim(Some(&args.out))?;
    StudyFolder::fill(folder, |folder| {
        for number in 0..args.random.unwrap_or(1) {
            let seed = args.seed.wrapping_add(number);
            let scene = of_file.clone().unwrap_or_else(|| FlankScene::drawn(seed, args.size, args.um_per_px));
            let (frame, mask, truth) = render_flank(&scene, seed).map_err(Failure::refuse)?;
            let picture = encode(&frame, FileFormat::Png8, scene.um_per_px).map_err(Failure::fail)?;
            folder.write(&format!("{number:06}.png"), &picture)?;
            let mask = write_grey(scene.columns as usize, &mask).map_err(Failure::fail)?;
            folder.write(&format!("{number:06}_land.png"), &mask)?;
            folder.write(&format!("{number:06}_truth.json"), (json_text(&truth)? + "\n").as_bytes())?;
        }
        Ok(())
    })?;
    Ok(Outcome::Done)
}
