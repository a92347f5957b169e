//! `shadowgauge study line-camera`: edges per second and repeatability of a line camera's readings.

use std::path::PathBuf;

use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::{ConfigText, json_text};
use crate::cli::terminal::progress;
use crate::config;
use crate::render::{BackendChoice, Renderer};
use crate::studies::line_camera::{self, BLOCK, LineCameraRow};

/// The head with line cameras that is studied where no config is given.
const LINE_HEAD: &str = include_str!("../../../configs/head_line_laser.toml");

/// Arguments of `study line-camera`.
#[derive(Debug, clap::Args)]
pub(crate) struct StudyLineCameraArgs {
    /// A job with `[camera.line]`; by default configs/head_line_laser.toml.
    config: Option<PathBuf>,
    /// Readings that are drawn and measured.
    #[arg(long, value_name = "N", default_value_t = 16_000, value_parser = clap::value_parser!(u32).range(1_000..=1_000_000))]
    readings: u32,
    /// Where they are rendered.
    #[arg(long, value_enum, default_value_t = BackendChoice::Cpu)]
    backend: BackendChoice,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Runs the study.
///
/// # Errors
/// Exit 2 for a config that is refused, 3 for a device that fails.
pub(crate) fn run(args: &StudyLineCameraArgs) -> CommandResult {
    let text = ConfigText::read_or(args.config.as_deref(), "configs/head_line_laser.toml", LINE_HEAD)?;
    let job = config::parse(&text.text, &text.name).map_err(Failure::refused)?;
    line_camera::check(&job).map_err(|e| text.refuse_at(e))?;
    let renderer = Renderer::new(args.backend).map_err(Failure::fail)?;
    let bar = progress::bar(u64::from(args.readings), "reading", "readings");
    let rows = line_camera::run(&job, args.readings as usize, &renderer, &|| bar.inc(1));
    let rows = rows.map_err(Failure::fail)?;
    bar.finish_and_clear();
    if args.json {
        say_line!("{}", json_text(&rows)?);
        return Ok(Outcome::Done);
    }
    let rate_khz = job.camera.line.map_or(0.0, |line| line.rate_khz);
    say_line!(
        "{}: {} readings of {} pixels; the camera's {rate_khz} kHz need {:.0} edges/s",
        job.name,
        args.readings,
        job.camera.rows,
        2e3 * rate_khz
    );
    say_line!(
        "{:>14}  {:>9}  {:>7}  {:>16}  {:>8}  {:>8}  {:>12}",
        "",
        "edges/s",
        "kHz",
        "repeatability/µm",
        "bound/µm",
        "mean/µm",
        "rms(error/u)"
    );
    rows.iter().for_each(|row| say_line!("{}", line(row)));
    Ok(Outcome::Done)
}

fn line(row: &LineCameraRow) -> String {
    let way = if row.way == "blocks" { format!("blocks of {BLOCK}") } else { "one by one".to_owned() };
    let lost = if row.lost > 0 { format!("  {} lost", row.lost) } else { String::new() };
    format!(
        "{way:>14}  {:>9.0}  {:>7.2}  {:>16.4}  {:>8.4}  {:>8.4}  {:>12.3}{lost}",
        row.edges_per_s, row.rate_khz, row.repeatability_um, row.bound_um, row.mean_um, row.rms_error_over_u
    )
}
