//! `shadowgauge study in-process`: the same job scanned after every pass and while it is cut.

use std::path::PathBuf;

use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::{ConfigText, StudyFolder, csv_text, json_text};
use crate::cli::terminal::progress;
use crate::config;
use crate::render::{BackendChoice, Renderer};
use crate::report::html::Page;
use crate::report::plot::{Chart, Mark, Series};
use crate::studies::in_process::{self, InProcessRow};

/// Arguments of `study in-process`.
#[derive(Debug, clap::Args)]
pub(crate) struct StudyInProcessArgs {
    /// The job; by default the preset (configs/slender_shaft.toml).
    config: Option<PathBuf>,
    /// Seed, in place of the config's.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Where frames are rendered.
    #[arg(long, value_enum, default_value_t = BackendChoice::Auto)]
    backend: BackendChoice,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write in_process.csv, in_process.svg and report.html into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Runs the study.
///
/// # Errors
/// Exit 2 for a config that is refused, 3 for a device or a disk that fails.
pub(crate) fn run(args: &StudyInProcessArgs) -> CommandResult {
    let text =
        ConfigText::read_or(args.config.as_deref(), "configs/slender_shaft.toml", config::SLENDER_SHAFT)?;
    let mut job = config::parse(&text.text, &text.name).map_err(Failure::refused)?;
    job.seed = args.seed.unwrap_or(job.seed);
    in_process::check(&job).map_err(|e| text.refuse_at(e))?;
    let folder = StudyFolder::claim(args.out.as_deref())?;
    let renderer = Renderer::new(args.backend).map_err(Failure::fail)?;
    let bar = progress::bar(in_process::passes_in_all(&job) as u64, "turning", "passes");
    let rows = in_process::run(&job, &renderer, &mut |row| {
        tracing::info!(way = row.way, pass = row.pass, "turned");
        bar.inc(1);
    })
    .map_err(Failure::fail)?;
    bar.finish_and_clear();
    StudyFolder::fill(folder, |folder| write(folder, &rows))?;
    if args.json {
        say_line!("{}", json_text(&rows)?);
        return Ok(Outcome::Done);
    }
    say_line!("{}", HEADER.join("  "));
    for row in &rows {
        say_line!("{}", cells(row).join("  "));
    }
    Ok(Outcome::Done)
}

const HEADER: [&str; 10] = [
    "scanned                ",
    "pass",
    "true max/µm",
    "true rms/µm",
    "reading max/µm",
    "reading mean/µm",
    "rms(error/u)",
    "stations",
    "frames (refused)",
    "radial force/N, deflection/µm",
];

fn cells(r: &InProcessRow) -> Vec<String> {
    vec![
        format!("{:<23}", r.way),
        format!("{:>4}", r.pass),
        format!("{:>11.2}", r.true_max_um),
        format!("{:>11.2}", r.true_rms_um),
        format!("{:>14.2}", r.reading_max_um),
        format!("{:>15.3}", r.reading_mean_um),
        format!("{:>12.2}", r.rms_error_over_u),
        format!("{:>8}", r.stations),
        format!("{:>16}", format!("{} ({})", r.frames, r.refused)),
        format!("{:.1}, {:.2}", r.radial_force_n, r.deflection_um),
    ]
}

fn write(folder: &StudyFolder, rows: &[InProcessRow]) -> Result<(), Failure> {
    let mut series: Vec<Series> = Vec::new();
    for row in rows {
        let point = (f64::from(row.pass), row.true_max_um);
        match series.iter_mut().find(|s| s.name == row.way) {
            Some(line) => line.points.push(point),
            None => series.push(Series::new(row.way, Mark::LineDots, series.len(), vec![point])),
        }
    }
    let chart = Chart {
        x_label: "pass".to_owned(),
        y_label: "true max |error| / µm".to_owned(),
        x_labels: Some(rows.iter().map(|r| r.pass as usize).max().unwrap_or(1)),
        series,
        log_y: true,
        ..Chart::default()
    };
    let svg = chart.to_svg().map_err(Failure::fail)?;
    let mut page = Page::new("Scanned after the pass and during the cut");
    page.text(
        "The same shaft, turned once with the part scanned at standstill after every pass, once with a gauge that follows the tool, \
         and once more with the stations ahead corrected within the pass. True errors are for comparison only.",
    );
    page.figure(&svg, "Largest true error over the stations after each pass.");
    page.table(&HEADER, &rows.iter().map(cells).collect::<Vec<_>>());
    folder.write("in_process.csv", &csv_text(rows)?)?;
    folder.write("in_process.svg", svg.as_bytes())?;
    folder.write("report.html", page.finish().as_bytes())
}
