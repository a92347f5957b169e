//! One error for a setting out of its range, and the check that gives it.

use thiserror::Error;

/// A setting out of its range.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{key} = {value} is out of range; right would be {right}")]
pub struct SettingError {
    /// The dotted key.
    pub key: String,
    /// The value found.
    pub value: f64,
    /// What would be right.
    pub right: &'static str,
}

/// Refuses what is not finite or lies outside `low ..= high`.
pub(crate) fn within(
    key: &str,
    value: f64,
    low: f64,
    high: f64,
    right: &'static str,
) -> Result<(), SettingError> {
    if value.is_finite() && (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(SettingError { key: key.to_owned(), value, right })
    }
}
