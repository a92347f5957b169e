//! Ctrl-C on a stream: it ends the stream, so that what was measured is still summed up.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::cli::failure::Failure;

/// How a shell reports a command that Ctrl-C ended.
const INTERRUPTED: i32 = 130;

/// What becomes true at the first Ctrl-C; the second one ends the process.
///
/// # Errors
/// A system that refuses the handler.
pub(super) fn stop_on_interrupt() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&stop);
    let handler = move || {
        if seen.swap(true, Ordering::Relaxed) {
            std::process::exit(INTERRUPTED);
        }
    };
    ctrlc::set_handler(handler).map_err(|e| Failure::fail(format!("no handler of Ctrl-C: {e}")))?;
    Ok(stop)
}
