//! `shadowgauge completions`: what a shell needs to complete the program's commands and options.

use clap::Command;
use clap_complete::{Shell, generate};

use super::failure::{CommandResult, Outcome};

/// Arguments of `completions`.
#[derive(Debug, clap::Args)]
pub(crate) struct CompletionsArgs {
    /// The shell; the script is printed on stdout.
    #[arg(value_enum)]
    shell: Shell,
}

/// Prints the script for `program`.
///
/// # Errors
/// Never.
pub(crate) fn run(arguments: &CompletionsArgs, program: Command) -> CommandResult {
    let mut program = program;
    let mut script = Vec::new();
    generate(arguments.shell, &mut program, "shadowgauge", &mut script);
    say!("{}", String::from_utf8_lossy(&script));
    Ok(Outcome::Done)
}
