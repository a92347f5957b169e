//! `shadowgauge reference`: the pages of `docs/reference` that follow from the program itself.
//!
//! In: the command line's definition and the settings of every config file. Out: Markdown pages and
//! JSON Schemas. `commands` is the command line, `config_page` the tables and keys of the config
//! files (from `config::kinds`, with the ranges that `ranges` reads from the checks), `exit_codes`
//! how a command ends, `examples` what `--help` ends with. A new config file is a line of
//! `config::kinds`, a new command a line of `examples`.

mod commands;
mod config_page;
pub(super) mod examples;
mod exit_codes;
mod markdown;
mod ranges;

use std::path::PathBuf;

use super::failure::{CommandResult, Outcome};
use crate::config::kinds::{CONFIGS, TABLES, schema_text};
use crate::files::{OutputFile, make_folder};

/// Arguments of `reference`.
#[derive(Debug, clap::Args)]
pub(crate) struct ReferenceArgs {
    /// Folder of the pages.
    #[arg(long, value_name = "DIR", default_value = "docs/reference")]
    out: PathBuf,
}

/// A page of the reference.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Page {
    /// Its file's name.
    pub name: String,
    /// Its text.
    pub text: String,
}

/// All pages, for the command line of `program`.
pub(crate) fn pages(program: &clap::Command) -> Vec<Page> {
    let page = |name: &str, text: String| Page { name: name.to_owned(), text };
    let mut pages = vec![
        page("commands.md", commands::page(program)),
        page("config.md", config_page::page(&CONFIGS, &ranges::of_job())),
        page("exit_codes.md", exit_codes::page()),
    ];
    let kinds = CONFIGS.iter().chain(&TABLES);
    pages.extend(kinds.map(|kind| page(&format!("{}.schema.json", kind.name), schema_text(kind))));
    pages
}

/// Writes the pages for the command line of `program`.
///
/// # Errors
/// Exit 3 where the folder cannot be written.
pub(crate) fn run(arguments: &ReferenceArgs, program: &clap::Command) -> CommandResult {
    make_folder(&arguments.out)?;
    for page in pages(program) {
        OutputFile::claim(&arguments.out.join(&page.name), [])?.write(page.text.as_bytes())?;
    }
    Ok(Outcome::Done)
}
