//! Exceptions: the classes of `shadowgauge/errors.py`, with the words of the library and program.

use pyo3::prelude::*;

/// An exception of a class by its name.
pub(crate) fn raise(py: Python<'_>, class: &str, text: impl std::fmt::Display) -> PyErr {
    let made = py
        .import("shadowgauge.errors")
        .and_then(|module| module.getattr(class))
        .and_then(|class| class.call1((text.to_string(),)));
    match made {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}

/// A config that is refused, with what to write instead where that is known.
pub(crate) fn refused_config(py: Python<'_>, error: &shadowgauge::config::ConfigError) -> PyErr {
    let help = miette::Diagnostic::help(error).map(|help| format!("\nhelp: {help}")).unwrap_or_default();
    raise(py, "ConfigError", format!("{error}{help}"))
}

/// The value of a JSON text from the Python half.
pub(crate) fn from_json<T: serde::de::DeserializeOwned>(
    py: Python<'_>,
    what: &str,
    text: &str,
) -> PyResult<T> {
    serde_json::from_str(text).map_err(|error| raise(py, "SettingError", format!("{what}: {error}")))
}
