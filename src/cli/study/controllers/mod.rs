//! `shadowgauge study controllers`: every controller on the same shafts, through rendered and
//! measured frames; beside them programs by their command lines.
//!
//! `command` reads a command line and is the study's contestant, `process` the stream to what it
//! starts.

mod command;
mod process;

use std::path::PathBuf;
use std::time::Duration;

use self::command::{CommandLine, StartedCommand};
use crate::cli::failure::{CommandResult, Failure};
use crate::cli::input_output::{ConfigText, StudyFolder, csv_text, say_study};
use crate::cli::terminal::progress;
use crate::config;
use crate::control::ControllerName;
use crate::render::{BackendChoice, Renderer};
use crate::report::html::Page;
use crate::report::plot::{Chart, Mark, Series, bars};
use crate::studies::controllers::{self, Contestant, ControllerStudy};

const CONFIG: &str = include_str!("../../../../configs/controllers.toml");

/// Arguments of `study controllers`.
#[derive(Debug, clap::Args)]
pub(crate) struct StudyControllersArgs {
    /// The job; by default the preset's shaft with disturbances (configs/controllers.toml).
    config: Option<PathBuf>,
    /// Shafts that every controller turns.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    shafts: u32,
    /// Controllers, by default all.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    controllers: Vec<ControllerName>,
    /// Another program as a controller, compared on equal terms: CMD or NAME=CMD, JSON lines on its
    /// stdin and stdout (docs/controllers.md), a process a shaft. Repeatable.
    #[arg(long, value_name = "CMD")]
    with_command: Vec<CommandLine>,
    /// Time in which a program must reply to a pass, and end after its last, s. The default leaves
    /// an interpreter time to load its numerical libraries on a busy machine.
    #[arg(long, value_name = "S", default_value_t = 30, value_parser = clap::value_parser!(u64).range(1..=86_400))]
    command_timeout_s: u64,
    /// Seed of the first shaft, in place of the config's.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Where frames are rendered.
    #[arg(long, value_enum, default_value_t = BackendChoice::Auto)]
    backend: BackendChoice,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write runs.csv, controllers.svg and report.html into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Runs the study.
///
/// # Errors
/// Exit 2 for a config, a controller or a command that is refused, 3 for a program, a device or a
/// disk that fails.
pub(crate) fn run(args: &StudyControllersArgs) -> CommandResult {
    let text = ConfigText::read_or(args.config.as_deref(), "configs/controllers.toml", CONFIG)?;
    let mut job = match &args.config {
        // with the files that it names: a contour, a measured edge
        Some(path) => config::load(path),
        None => config::parse(&text.text, &text.name),
    }
    .map_err(Failure::refused)?;
    job.check_coverage().map_err(|e| text.refuse_at(e))?;
    job.seed = args.seed.unwrap_or(job.seed);
    let names =
        if args.controllers.is_empty() { ControllerName::ALL.to_vec() } else { args.controllers.clone() };
    command::check_names(&args.with_command).map_err(Failure::refuse)?;
    for controller in &names {
        let mut settings = job.loop_job().run_control();
        settings.controller = *controller;
        crate::control::build(&settings, job.loop_job().layout()).map_err(|e| text.refuse(e))?;
    }
    let folder = StudyFolder::claim(args.out.as_deref())?;
    let programs = start_commands(args)?;
    let own = names.into_iter().map(Contestant::Own);
    let contestants: Vec<Contestant<'_>> =
        own.chain(programs.iter().map(|p| Contestant::Program(p))).collect();
    let renderer = Renderer::new(args.backend).map_err(Failure::fail)?;
    let bar = progress::bar(u64::from(args.shafts) * (contestants.len() as u64 + 1), "turning", "shafts");
    let study = controllers::run(&job, &contestants, args.shafts as usize, &renderer, &mut |name, seed| {
        tracing::info!(controller = name, seed, "turned");
        bar.inc(1);
    })
    .map_err(Failure::fail)?;
    bar.finish_and_clear();
    StudyFolder::fill(folder, |folder| write(folder, &study))?;
    say_study(&study, args.json, print)
}

/// Starts every command once.
fn start_commands(args: &StudyControllersArgs) -> Result<Vec<StartedCommand>, Failure> {
    let timeout = Duration::from_secs(args.command_timeout_s);
    let started = args.with_command.iter().map(|line| StartedCommand::new(line, timeout));
    started.collect::<Result<_, _>>().map_err(Failure::refuse)
}

/// Least width of the names' column: that of the controllers of `[control]`.
const LEAST_WIDTH: usize = 6;

fn print(study: &ControllerStudy) {
    let names = study.controllers.iter().map(|c| c.controller.chars().count());
    let width = names.fold(LEAST_WIDTH, usize::max);
    say_line!(
        "largest true error over the stations, µm: mean ± 95 % interval (median, worst; worst share of none)"
    );
    for c in &study.controllers {
        for p in &c.passes {
            say_line!(
                "{:<width$} pass {}  {:8.2} ± {:>5}  ({:7.2}, {:7.2}; {:.3})",
                c.controller,
                p.pass,
                p.mean_mm * 1e3,
                p.interval_mm.map_or_else(|| "-".to_owned(), |i| format!("{:.2}", i * 1e3)),
                p.median_mm * 1e3,
                p.worst_mm * 1e3,
                p.worst_share_of_none
            );
        }
        if c.held > 0 {
            say_line!("{:<width$} held {} times", c.controller, c.held);
        }
    }
}

/// Error over the passes, one line per controller.
fn error_chart(study: &ControllerStudy) -> Chart {
    let mut series = Vec::new();
    for (i, c) in study.controllers.iter().enumerate() {
        let line = |f: fn(&controllers::PassSummary) -> f64| {
            c.passes.iter().map(|p| (f64::from(p.pass), f(p) * 1e3)).collect::<Vec<_>>()
        };
        series.push(Series::new(c.controller.clone(), Mark::LineDots, i, line(|p| p.mean_mm)));
        let half = |p: &controllers::PassSummary| p.interval_mm.unwrap_or(0.0);
        let intervals = c.passes.iter().filter(|p| p.interval_mm.is_some());
        let ends = bars(intervals.map(|p| (f64::from(p.pass), p.mean_mm * 1e3, half(p) * 1e3)));
        series.push(Series::new("", Mark::Bars, i, ends));
    }
    Chart {
        x_label: "pass".to_owned(),
        y_label: "largest true error / µm".to_owned(),
        series,
        log_y: true,
        x_labels: study.controllers.first().map(|c| c.passes.len()),
        ..Chart::default()
    }
}

fn pass_rows(study: &ControllerStudy) -> Vec<Vec<String>> {
    study
        .controllers
        .iter()
        .flat_map(|c| {
            c.passes.iter().map(move |p| {
                vec![
                    c.controller.clone(),
                    p.pass.to_string(),
                    format!("{:.2}", p.mean_mm * 1e3),
                    p.interval_mm.map_or_else(String::new, |i| format!("± {:.2}", i * 1e3)),
                    format!("{:.2}", p.median_mm * 1e3),
                    format!("{:.2}", p.worst_mm * 1e3),
                    format!("{:.1} %", p.worst_share_of_none * 100.0),
                ]
            })
        })
        .collect()
}

fn write(folder: &StudyFolder, study: &ControllerStudy) -> Result<(), Failure> {
    let svg = error_chart(study).to_svg().map_err(Failure::fail)?;
    let mut page = Page::new("Controllers on equal terms");
    page.text(&format!(
        "{} shafts, the same for every controller; each pass cut, rendered, measured and corrected from the pixels. The \
         first pass knows no correction.",
        study.shafts
    ));
    page.figure(
        &svg,
        "Mean over the shafts of the largest true error, with its 95 % interval (Student's t).",
    );
    page.table(
        &["controller", "pass", "mean / µm", "95 %", "median / µm", "worst / µm", "worst share of none"],
        &pass_rows(study),
    );
    let commands: Vec<Vec<String>> = study
        .controllers
        .iter()
        .filter_map(|c| Some(vec![c.controller.clone(), c.command.clone()?]))
        .collect();
    if !commands.is_empty() {
        page.heading("Programs").table(&["controller", "command"], &commands);
    }
    let held: Vec<Vec<String>> = study
        .runs
        .iter()
        .filter(|r| !r.held.is_empty())
        .map(|r| vec![r.controller.clone(), r.seed.to_string(), r.pass.to_string(), r.held.clone()])
        .collect();
    if !held.is_empty() {
        page.heading("Offsets held").table(&["controller", "seed", "after pass", "reason"], &held);
    }
    folder.write("runs.csv", &csv_text(&study.runs)?)?;
    folder.write("controllers.svg", svg.as_bytes())?;
    folder.write("report.html", page.finish().as_bytes())
}
