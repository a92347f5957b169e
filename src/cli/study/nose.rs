//! `shadowgauge study nose`: noses of rendered inserts, measured, beside their stated
//! uncertainties.

use std::path::PathBuf;

use crate::cli::failure::{CommandResult, Outcome};
use crate::cli::input_output::{ConfigText, json_text};
use crate::cli::terminal::progress;
use crate::render::insert::InsertSettings;
use crate::studies::noses::{self, NoseRow};

/// The insert that is studied where no config is given: the camera and the tool of paper 004.
const INSERT: &str = "[nose]\nradius_mm = 0.4\n\n[esf.gaussian]\nsigma_px = 1.2\n";

/// Arguments of `study nose`.
#[derive(Debug, clap::Args)]
pub(crate) struct StudyNoseArgs {
    /// A TOML file with insert, optics and camera (`schema insert`); direction, place and wear of
    /// the nose are drawn. By default the insert and the camera of paper 004.
    config: Option<PathBuf>,
    /// Noses: a fifth of each are new, worn round, worn flat, dented, chipped.
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(5..=10_000))]
    noses: u32,
    /// Seed of poses, wear and noise.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Runs the study.
///
/// # Errors
/// Exit 2 for a config that is refused.
pub(crate) fn run(args: &StudyNoseArgs) -> CommandResult {
    let text = ConfigText::read_or(args.config.as_deref(), "built-in insert", INSERT)?;
    let settings: InsertSettings = text.parse()?;
    settings.check().map_err(|e| text.refuse(e))?;
    let bar = progress::bar(u64::from(args.noses), "measuring", "noses");
    let rows = noses::run(&settings, args.noses as usize, args.seed, &|| bar.inc(1));
    let rows = rows.map_err(|e| text.refuse(e))?;
    bar.finish_and_clear();
    if args.json {
        say_line!("{}", json_text(&rows)?);
        return Ok(Outcome::Done);
    }
    let camera = settings.camera;
    say_line!(
        "{} x {} px of {} µm; errors: largest (rms of error/u)",
        camera.columns,
        camera.rows,
        camera.um_per_px
    );
    say_line!(
        "{:>6} {:>5} {:>7}  {:>16}  {:>14}  {:>14}  {:>19}  {:>19}  {:>14}",
        "",
        "noses",
        "refused",
        "angle/°",
        "centre/px",
        "mean radius/px",
        "sectors rms/px, 95%",
        "support rms/px, 95%",
        "e rms, most/µm"
    );
    rows.iter().for_each(|row| say_line!("{}", line(row)));
    Ok(Outcome::Done)
}

fn line(row: &NoseRow) -> String {
    format!(
        "{:>6} {:>5} {:>7}  {:>9.5} ({:>4.2})  {:>7.4} ({:>4.2})  {:>7.4} ({:>4.2})  {:>11.4}, {:>5.1} %  {:>11.4}, {:>5.1} %  \
         {:>6.3}, {:>6.3}",
        row.wear,
        row.noses,
        row.refused,
        row.angle.largest,
        row.angle.over_u,
        row.centre.largest,
        row.centre.over_u,
        row.mean_radius.largest,
        row.mean_radius.over_u,
        row.sectors.rms_px,
        1e2 * row.sectors.within,
        row.support.rms_px,
        1e2 * row.support.within,
        row.e_um[0],
        row.e_um[1]
    )
}
