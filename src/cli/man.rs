//! `shadowgauge man`: manual pages, for `man`.
//!
//! In: the program's definition. Out: its page on stdout, or a page of every command in a folder.

use std::path::PathBuf;

use clap::Command;
use clap_mangen::Man;

use super::failure::{CommandResult, Failure, Outcome};
use crate::files::{OutputFile, make_folder};

/// Arguments of `man`.
#[derive(Debug, clap::Args)]
pub(crate) struct ManArgs {
    /// Write the page of every command into this folder, in place of the program's to stdout.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Writes the pages of `program`.
///
/// # Errors
/// Exit 3 where the folder cannot be written.
pub(crate) fn run(arguments: &ManArgs, program: Command) -> CommandResult {
    let Some(folder) = &arguments.out else {
        say!("{}", String::from_utf8_lossy(&page(program)?));
        return Ok(Outcome::Done);
    };
    make_folder(folder)?;
    let mut program = program.disable_help_subcommand(true);
    program.build();
    for command in with_all_below(program) {
        let name = command.get_display_name().unwrap_or_else(|| command.get_name());
        let path = folder.join(format!("{name}.1"));
        OutputFile::claim(&path, [])?.write(&page(command)?)?;
    }
    Ok(Outcome::Done)
}

/// A command that is built, and those below it, which are then displayed under their whole names:
/// `shadowgauge-study-parts`.
fn with_all_below(command: Command) -> Vec<Command> {
    let below = command.get_subcommands().filter(|below| !below.is_hide_set()).cloned();
    let below: Vec<Command> = below.flat_map(with_all_below).collect();
    std::iter::once(command).chain(below).collect()
}

fn page(command: Command) -> Result<Vec<u8>, Failure> {
    let mut page = Vec::new();
    Man::new(command).render(&mut page).map_err(Failure::fail)?;
    Ok(page)
}
