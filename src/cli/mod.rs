//! The command line: one file a subcommand. `main.rs` parses, calls, prints the error.
//!
//! Exit codes: 0 done, in tolerance where one is given; 1 a given tolerance is exceeded; 2 the command line or the
//! config is refused; 3 a file, an image, an output or a device fails. Data on stdout, logs on stderr.

pub mod measure_ring;
mod schema;

use std::io::IsTerminal as _;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

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
    /// Print the JSON Schema of a config file.
    Schema,
}

fn dispatch(command: &Command) -> CommandResult {
    match command {
        Command::Schema => schema::run(),
    }
}

/// Parses the process's arguments, runs the command, prints the error; gives the exit code of the contract.
pub fn main() -> ExitCode {
    let arguments = Arguments::parse();
    log_to_stderr(arguments.verbose);
    match dispatch(&arguments.command) {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::OutOfTolerance) => ExitCode::from(1),
        Err(failure) => {
            eprintln!("{:?}", failure.report);
            ExitCode::from(failure.exit)
        }
    }
}

fn log_to_stderr(verbose: u8) {
    let level = ["shadowgauge=warn", "shadowgauge=info", "shadowgauge=debug"][usize::from(verbose.min(2))];
    let filter = tracing_subscriber::EnvFilter::try_from_default_env().unwrap_or_else(|_| level.into());
    let colour = std::env::var_os("NO_COLOR").is_none() && std::io::stderr().is_terminal();
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_ansi(colour)
        .without_time()
        .with_target(false)
        .init();
}
