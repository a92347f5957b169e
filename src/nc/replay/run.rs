//! One run of a program.

#[cfg(test)]
use std::collections::HashMap;

use super::event::{Event, Fault};
use super::flow::Program;
use super::interpreter::{Control, Interpreter};

/// Runs a program from one start position and lists its events.
///
/// # Errors
/// Line (from 1) and reason where it cannot be interpreted.
pub(crate) fn run(text: &str, control: &Control<'_>) -> Result<Vec<Event>, Fault> {
    let program = Program::new(text, control.dialect).map_err(|(line, why)| (line + 1, why))?;
    Ok(Interpreter::new(&program, control).run()?.0)
}

/// Runs a program from one start position and returns the final values of its variables, by number.
///
/// # Errors
/// As [`run`].
#[cfg(test)]
pub(crate) fn variables(text: &str, control: &Control<'_>) -> Result<HashMap<u32, f64>, Fault> {
    let program = Program::new(text, control.dialect).map_err(|(line, why)| (line + 1, why))?;
    Ok(Interpreter::new(&program, control).run()?.1)
}
