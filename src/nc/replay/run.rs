//! One run of a program.

use super::flow::Program;
use super::interpreter::{Control, Event, Fault, Interpreter};

/// Runs a program from one start position and lists what it does.
///
/// # Errors
/// Line (from 1) and reason where it is not understood.
pub fn run(text: &str, control: &Control<'_>) -> Result<Vec<Event>, Fault> {
    let program = Program::new(text).map_err(|(line, why)| (line + 1, why))?;
    Interpreter::new(&program, control).run()
}
