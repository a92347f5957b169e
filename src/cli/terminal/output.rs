//! Output of a command on stdout. A stream that fails must not abort a command half way: the first
//! error is kept, further output is dropped, and [`finish`] reports the error at the end (as GNU's
//! `close_stdout` does).

use std::fmt::Arguments;
use std::io::{Error, ErrorKind, Write as _, stdout};
use std::sync::OnceLock;

use crate::cli::failure::Failure;

static FIRST_ERROR: OnceLock<Error> = OnceLock::new();

/// Writes to stdout; nothing after an error.
pub(crate) fn write(text: Arguments<'_>) {
    if FIRST_ERROR.get().is_none() {
        keep(stdout().lock().write_fmt(text));
    }
}

fn keep(result: Result<(), Error>) {
    if let Err(error) = result {
        // Only the first one is reported.
        let _ = FIRST_ERROR.set(error);
    }
}

/// Writes out what was written so far: for a command that goes on without an end.
pub(crate) fn flush() {
    if FIRST_ERROR.get().is_none() {
        keep(stdout().lock().flush());
    }
}

/// Whether nothing more can be written: then a stream need not be measured on.
pub(crate) fn has_failed() -> bool {
    FIRST_ERROR.get().is_some()
}

/// Reports a failed write. A closed pipe (`… | head -1`) is not a failure.
///
/// # Errors
/// Exit 3 where stdout cannot be written.
pub(crate) fn finish() -> Result<(), Failure> {
    flush();
    match FIRST_ERROR.get() {
        Some(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::fail(format!("stdout cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}

/// As `print!`, without its panic.
macro_rules! say {
    ($($text:tt)*) => { $crate::cli::terminal::output::write(::std::format_args!($($text)*)) };
}

/// As `println!`, without its panic.
macro_rules! say_line {
    () => { say!("\n") };
    ($($text:tt)*) => { say!("{}\n", format_args!($($text)*)) };
}
