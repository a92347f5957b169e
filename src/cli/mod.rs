//! The command line: one file or folder per subcommand. [`main`] parses, calls, prints the error.
//!
//! Exit codes: 0 done, in tolerance where one is given; 1 a given tolerance is exceeded; 2 the
//! command line or the config is refused; 3 a file, an image, an output or a device fails. Data on
//! stdout, logs on stderr.
//!
//! In: arguments and files. Out: what the library computed, as text, JSON and files; a command
//! contains no computation that belongs in the library. Beside the commands are `failure` (how a
//! command ends), `terminal` (stdout, log and progress), `process` (the environment of graphics
//! drivers, Ctrl-C), `input_output` (configs in, folders out) and `calibration_plan` (read by
//! several commands). A new command is a file with its arguments and a function `run`, a line of
//! `commands!` and its examples in `reference::examples`; no command imports this file.

#[macro_use]
mod terminal;

mod calibrate;
mod calibration_plan;
mod completions;
mod demo;
mod doctor;
mod failure;
mod input_output;
mod man;
mod measure;
mod nc;
mod new;
mod optics;
mod optimize;
mod process;
mod publish;
mod reference;
mod render;
mod reproduce;
mod run;
mod schema;
mod serve;
mod store;
mod study;
mod tool;
mod watch;

use std::ffi::OsString;
use std::io::Write as _;
use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};

use failure::{CommandResult, Outcome};
pub use reference::Page;
use terminal::{log, output};

#[derive(Debug, Parser)]
#[command(name = "shadowgauge", version, about, long_about = None)]
struct Arguments {
    /// More on stderr: -v info, -vv debug (or set RUST_LOG).
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    verbose: u8,
    #[command(subcommand)]
    command: Command,
}

/// Declares the commands: one line each, with its help, its arguments and the function that runs
/// it.
macro_rules! commands {
    ($($(#[$about:meta])* $name:ident($arguments:ty) => $run:path,)*) => {
        #[derive(Debug, Subcommand)]
        enum Command {
            $($(#[$about])* $name($arguments),)*
        }

        fn dispatch(command: &Command) -> CommandResult {
            match command {
                $(Command::$name(arguments) => $run(arguments),)*
            }
        }
    };
}

commands! {
    /// The main job with the built-in preset: cut, render, measure, correct, cut again.
    Demo(demo::DemoArgs) => demo::run,
    /// Run a config's job: pass after pass into a run folder, with a report.
    Run(Box<run::RunArgs>) => run::run,
    /// Render shadowgraph frames of a config's shaft with their truth.
    Render(render::RenderArgs) => render::run,
    /// Publish the head of a config as a GigE Vision camera.
    Publish(publish::PublishArgs) => publish::run,
    /// Show adapters, drivers, what `auto` would choose and what is missing.
    Doctor(doctor::DoctorArgs) => doctor::run,
    /// Calibrate an optical setup: dark and flat fields, master pins, a check pin.
    Calibrate(calibrate::CalibrateArgs) => calibrate::run,
    /// Show a config's optics.
    #[command(subcommand)]
    Optics(optics::OpticsCommand) => optics::run,
    /// Measure edges and diameters of frames in files.
    Measure(Box<measure::MeasureArgs>) => measure::run,
    /// Watch a source live: the diameter of now, one value a part, an alarm.
    Watch(Box<watch::WatchArgs>) => watch::run,
    /// Print a commented start for a file of one's own.
    New(new::NewArgs) => new::run,
    /// Print the JSON Schema of a config file or of a table's row.
    Schema(schema::SchemaArgs) => schema::run,
    /// Choose cutting data: the shortest time under limits of size error and roughness.
    Optimize(optimize::OptimizeArgs) => optimize::run,
    /// A paper's figures beside ours.
    #[command(subcommand)]
    Reproduce(reproduce::Paper) => reproduce::run,
    /// Write the offsets of a run, or a model of a part, as an NC program.
    Nc(Box<nc::NcArgs>) => nc::run,
    /// The nose of a turning tool, and what it does to a part.
    #[command(subcommand)]
    Tool(tool::ToolCommand) => tool::run,
    /// Serve a page with runs, history and a live source, on this machine.
    Serve(serve::ServeArgs) => serve::run,
    /// What a store of runs and measurements holds.
    #[command(subcommand)]
    Store(store::StoreCommand) => store::run,
    /// Measurements over the stages.
    #[command(subcommand)]
    Study(study::Study) => study::run,
    /// Print the completions of a shell.
    Completions(completions::CompletionsArgs) => print_completions,
    /// Print or write the manual pages.
    Man(man::ManArgs) => write_manual,
    /// Write the pages of docs/reference that follow from the program.
    #[command(hide = true)]
    Reference(reference::ReferenceArgs) => write_reference,
}

/// The definition of the command line.
pub fn command() -> clap::Command {
    reference::examples::with_examples(Arguments::command())
}

/// The pages of `docs/reference` that follow from the program.
pub fn reference_pages() -> Vec<Page> {
    reference::pages(&command())
}

fn write_reference(arguments: &reference::ReferenceArgs) -> CommandResult {
    reference::run(arguments, &command())
}

fn print_completions(arguments: &completions::CompletionsArgs) -> CommandResult {
    completions::run(arguments, command())
}

fn write_manual(arguments: &man::ManArgs) -> CommandResult {
    man::run(arguments, command())
}

/// Arguments, the program's name first; ends the process with a message where they are refused.
fn arguments(given: impl IntoIterator<Item = OsString>) -> Arguments {
    let mut command = command();
    let given: Vec<OsString> = given.into_iter().collect();
    let mut matches = command.try_get_matches_from_mut(&given).unwrap_or_else(|error| {
        let refusal = study::unsplit::refusal(&given).filter(|_| error.kind() == ErrorKind::UnknownArgument);
        refusal.map_or(error, |text| command.error(ErrorKind::UnknownArgument, text)).exit()
    });
    Arguments::from_arg_matches_mut(&mut matches).unwrap_or_else(|error| error.format(&mut command).exit())
}

/// Parses the process's arguments, runs the command, prints the error; returns the exit code
/// defined above.
pub fn main() -> ExitCode {
    process::provide_runtime_folder();
    process::leave(run_arguments(std::env::args_os()))
}

/// Runs a command as the program does, from within another one: prints what it prints, and returns
/// its exit code. Once a process, whose stdout and log it takes; arguments that are refused, and
/// `--help`, end the process.
pub fn run_arguments(given: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments = arguments(given);
    log::start(arguments.verbose);
    let result = dispatch(&arguments.command).and_then(|outcome| output::finish().map(|()| outcome));
    log::finish();
    match result {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::OutOfTolerance) => 1,
        Err(failure) => {
            // Where stderr cannot be written either, only the exit code remains.
            let _ = writeln!(std::io::stderr(), "{:?}", failure.report);
            failure.exit
        }
    }
}

#[cfg(test)]
mod tests {
    use super::study::unsplit::REASONS;
    use super::*;

    #[test]
    fn every_study_is_split_or_has_a_reason() {
        let command = command();
        let studies = command.find_subcommand("study").unwrap();
        for study in studies.get_subcommands().filter(|study| study.get_name() != "merge") {
            let splits = study.get_arguments().any(|argument| argument.get_id() == "shard");
            let has_reason = REASONS.iter().any(|(name, _)| *name == study.get_name());
            assert_ne!(splits, has_reason, "{}", study.get_name());
        }
        assert_eq!(REASONS.len() + 3 + 1, studies.get_subcommands().count(), "three are split; merge");
    }
}
