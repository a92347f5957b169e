//! A setting out of range: the common error of all modules, and the checks that return it.

use std::fmt::Display;

use thiserror::Error;

/// A setting out of range, with its dotted key.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{key}{}: {problem}", self.found.as_ref().map_or(String::new(), |found| format!(" = {found}")))]
pub struct SettingError {
    /// Dotted key as in the TOML file, e.g. `optics.magnification`.
    pub key: String,
    /// The value found, where there is one.
    pub found: Option<String>,
    /// What is wrong, and the valid values.
    pub problem: String,
}

impl SettingError {
    /// An error at `key`, in words.
    pub(crate) fn at(key: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { key: key.into(), found: None, problem: problem.into() }
    }

    /// A value out of range for `key`; `right` follows "must be".
    pub(crate) fn of(key: impl Into<String>, found: impl Display, right: impl Display) -> Self {
        Self { found: Some(found.to_string()), ..Self::at(key, format!("must be {right}")) }
    }

    /// Value and problem, for a message that names the key itself.
    pub(crate) fn without_key(&self) -> String {
        self.found.iter().chain([&self.problem]).cloned().collect::<Vec<_>>().join(" ")
    }
}

/// Refuses a value for which the condition does not hold.
pub(crate) fn require(holds: bool, key: &str, value: impl Display, right: &str) -> Result<(), SettingError> {
    if holds { Ok(()) } else { Err(SettingError::of(key, value, right)) }
}

/// Refuses a value that is not finite or outside `low ..= high`.
pub(crate) fn within(key: &str, value: f64, low: f64, high: f64, right: &str) -> Result<(), SettingError> {
    require(value.is_finite() && (low..=high).contains(&value), key, value, right)
}

/// Refuses a value that is not finite and above 0.
pub(crate) fn positive(key: &str, value: f64) -> Result<(), SettingError> {
    require(value.is_finite() && value > 0.0, key, value, "a number above 0")
}
