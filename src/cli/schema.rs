//! `shadowgauge schema`: the JSON Schema of a config file, for editors.

use super::failure::{CommandResult, Outcome};

/// Prints the schema.
///
/// # Errors
/// Never.
pub fn run() -> CommandResult {
    say_line!("{}", crate::config::json_schema());
    Ok(Outcome::Done)
}
