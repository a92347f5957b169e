//! The command line: one file a subcommand. `main.rs` parses, calls, prints the error.
//!
//! Exit codes: 0 done, in tolerance where one is given; 1 a given tolerance is exceeded; 2 the command line or the
//! config is refused; 3 a file, an image, an output or a device fails. Data on stdout, logs on stderr.

#[macro_use]
mod output;

mod calibrate;
mod calibration_plan;
mod demo;
mod doctor;
mod esf_argument;
mod frame_files;
mod gallery_cases;
mod gpu_check;
mod label_font;
mod measure;
mod measure_bench;
mod measure_choice;
mod measure_crests;
mod measure_frames;
mod measure_judge;
pub mod measure_ring;
mod measure_size;
mod measure_statistics;
mod measure_turn;
mod measure_words;
mod nc;
mod optics;
mod optimize;
mod process;
mod record;
mod render;
mod render_bench;
mod render_calibration;
mod render_gallery;
mod reproduce;
mod reproduce_000;
mod reproduce_003;
mod reproduce_003_page;
mod run;
mod schema;
mod study;
mod study_contamination;
mod study_controllers;
mod study_coverage;
mod study_deflection;
mod study_factor;
mod study_files;
mod study_in_process;
mod study_line_camera;
mod study_parts;
mod study_stability;
mod study_uncertainty;
mod study_washers;

use std::io::{IsTerminal as _, Write as _};
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::files::OutputError;

/// How a command that did its work ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Done; in tolerance where one is given. Exit 0.
    Done,
    /// Done, but a given tolerance is exceeded. Exit 1.
    OutOfTolerance,
}

/// Why a command stopped, with the exit code that belongs to it.
#[derive(Debug)]
pub struct Failure {
    /// 2 refused, 3 failed.
    pub exit: u8,
    /// What a person reads.
    pub report: miette::Report,
}

impl Failure {
    /// The command line or the config is refused: exit 2.
    pub fn refused(report: impl Into<miette::Report>) -> Self {
        Self { exit: 2, report: report.into() }
    }

    /// A file, an image, an output or a device fails: exit 3.
    pub fn failed(report: impl Into<miette::Report>) -> Self {
        Self { exit: 3, report: report.into() }
    }

    /// As [`Self::refused`], from an error of the library or a text.
    pub fn refuse(error: impl std::fmt::Display) -> Self {
        Self::refused(miette::miette!("{error}"))
    }

    /// As [`Self::failed`], from an error of the library or a text.
    pub fn fail(error: impl std::fmt::Display) -> Self {
        Self::failed(miette::miette!("{error}"))
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        if error.is_refusal() { Self::refuse(error) } else { Self::fail(error) }
    }
}

/// What every subcommand returns.
pub type CommandResult = Result<Outcome, Failure>;

#[derive(Debug, Parser)]
#[command(name = "shadowgauge", version, about, long_about = None)]
struct Arguments {
    /// More on stderr: -v info, -vv debug (or set RUST_LOG).
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    verbose: u8,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// The main job with the built-in preset: cut, render, measure, correct, cut again.
    Demo(demo::DemoArgs),
    /// Run a config's job: pass after pass into a run folder, with a report.
    Run(run::RunArgs),
    /// Render shadowgraph frames of a config's shaft with their truth.
    Render(render::RenderArgs),
    /// Show adapters, drivers, what `auto` would choose and what is missing.
    Doctor(doctor::DoctorArgs),
    /// Calibrate a bench: dark and flat fields, master pins, a check pin.
    Calibrate(calibrate::CalibrateArgs),
    /// Show a config's optics.
    #[command(subcommand)]
    Optics(optics::OpticsCommand),
    /// Measure edges and diameters of frames in files.
    Measure(Box<measure::MeasureArgs>),
    /// Print the JSON Schema of a config file.
    Schema,
    /// Choose cutting data: the shortest time under limits of size error and roughness.
    Optimize(optimize::OptimizeArgs),
    /// A paper's figures beside ours.
    #[command(subcommand)]
    Reproduce(reproduce::Paper),
    /// Write the offsets of a run as an NC program.
    Nc(nc::NcArgs),
    /// Measurements over the stages.
    #[command(subcommand)]
    Study(study::Study),
}

fn dispatch(command: &Command) -> CommandResult {
    match command {
        Command::Demo(args) => demo::run(args),
        Command::Run(args) => run::run(args),
        Command::Render(args) => render::run(args),
        Command::Doctor(args) => doctor::run(args),
        Command::Calibrate(args) => calibrate::run(args),
        Command::Optics(command) => optics::run(command),
        Command::Measure(args) => measure::run(args),
        Command::Schema => schema::run(),
        Command::Optimize(args) => optimize::run(args),
        Command::Reproduce(paper) => reproduce::run(paper),
        Command::Nc(args) => nc::run(args),
        Command::Study(study) => study::run(study),
    }
}

/// Parses the process's arguments, runs the command, prints the error; gives the exit code of the contract.
pub fn main() -> ExitCode {
    process::provide_runtime_folder();
    let arguments = Arguments::parse();
    log_to_stderr(arguments.verbose);
    let result = dispatch(&arguments.command).and_then(|outcome| output::finish().map(|()| outcome));
    let status = match result {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::OutOfTolerance) => 1,
        Err(failure) => {
            // Where stderr takes nothing either, the exit code is all that is left.
            let _ = writeln!(std::io::stderr(), "{:?}", failure.report);
            failure.exit
        }
    };
    process::leave(status)
}

fn log_to_stderr(verbose: u8) {
    let level = ["shadowgauge=warn", "shadowgauge=info", "shadowgauge=debug"][usize::from(verbose.min(2))];
    let filter = tracing_subscriber::EnvFilter::try_from_default_env().unwrap_or_else(|_| level.into());
    let colour = std::env::var_os("NO_COLOR").is_none() && std::io::stderr().is_terminal();
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_ansi(colour)
        .log_internal_errors(false)
        .without_time()
        .with_target(false)
        .init();
}
