//! The program's command line.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the program's command line, the program's name first, and returns its exit code. It is the
/// process's own: it takes stdout and stderr, and arguments that are refused end the process.
#[pyfunction]
pub(crate) fn command_line(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| shadowgauge::cli::run_arguments(arguments))
}
