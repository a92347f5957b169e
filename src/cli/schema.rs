//! `shadowgauge schema`: the JSON Schema of a config file, for editors.

use super::failure::{CommandResult, Outcome};

/// Arguments of `schema`: none.
#[derive(Debug, clap::Args)]
pub(crate) struct SchemaArgs {}

/// Prints the schema.
///
/// # Errors
/// Never.
pub(crate) fn run(_: &SchemaArgs) -> CommandResult {
    say_line!("{}", crate::config::json_schema());
    Ok(Outcome::Done)
}
