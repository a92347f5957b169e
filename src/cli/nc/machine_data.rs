//! The machine's file: where an error of it lies.

use crate::cli::failure::Failure;
use crate::cli::input_output::ConfigText;
use crate::config;
use crate::nc::NcError;

/// An error that points at the key in the machine's file.
pub(super) fn in_file(file: &ConfigText, error: NcError) -> Failure {
    match error {
        NcError::Setting(mut at) => {
            at.key = at.key.strip_prefix("nc.").unwrap_or(&at.key).to_owned();
            Failure::refused(config::value_error(&file.text, &file.name, at))
        }
        other => file.refuse(other),
    }
}
