//! `shadowgauge schema`: the JSON Schemas of the files that a user writes, for editors.

use clap::builder::PossibleValuesParser;

use super::failure::{CommandResult, Failure, Outcome};
use crate::config::kinds;

/// Arguments of `schema`.
#[derive(Debug, clap::Args)]
pub(crate) struct SchemaArgs {
    /// Which file: a config in TOML, or a table in CSV (its schema is that of a row).
    #[arg(value_parser = PossibleValuesParser::new(kinds::names()), default_value = "job")]
    name: String,
}

/// Prints the schema.
///
/// # Errors
/// Exit 2 for a file that there is none of.
pub(crate) fn run(args: &SchemaArgs) -> CommandResult {
    let kind = kinds::find(&args.name)
        .ok_or_else(|| Failure::refuse(format!("{}: no file has this name", args.name)))?;
    say!("{}", kinds::schema_text(kind));
    Ok(Outcome::Done)
}
