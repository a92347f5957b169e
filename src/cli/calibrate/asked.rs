//! What the operator is asked for on the terminal, step by step.

use std::io::{BufRead as _, IsTerminal as _, Write as _};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::Duration;

use crate::cli::process::interrupt;
use crate::cli::terminal::progress;

/// Time after which it is looked whether Ctrl-C ended the command.
const LOOK: Duration = Duration::from_millis(50);

/// Why a step was not confirmed.
pub(super) const INTERRUPTED: &str = "interrupted";

/// Who changes the scene before the camera.
pub(super) trait Asks {
    /// Asks for a step, and waits until it is done.
    ///
    /// # Errors
    /// A step that is not done: why, as text.
    fn ask(&mut self, step: &str) -> Result<(), String>;

    /// Whether the command is to end.
    fn is_interrupted(&self) -> bool;
}

/// Lines of stdin, each of which confirms a step.
pub(super) struct Operator {
    lines: Receiver<()>,
    is_terminal: bool,
    stop: Arc<AtomicBool>,
}

impl Operator {
    /// Begins to read stdin. From here on Ctrl-C ends a step, so that the camera has its settings
    /// back.
    ///
    /// # Errors
    /// A system without another thread.
    pub(super) fn new() -> std::io::Result<Self> {
        let (give, lines) = sync_channel(0);
        let read = move || {
            let lines = std::io::stdin().lock().lines();
            let _ = lines.map_while(Result::ok).all(|_| give.send(()).is_ok());
        };
        std::thread::Builder::new().name("operator".to_owned()).spawn(read)?;
        Ok(Self { lines, is_terminal: std::io::stdin().is_terminal(), stop: interrupt::requested() })
    }
}

impl Asks for Operator {
    /// On stderr, and waits for Enter.
    fn ask(&mut self, step: &str) -> Result<(), String> {
        // Enter pressed twice at the last step does not confirm this one, for which nothing is laid
        // yet; the lines of a pipe are one a step.
        while self.is_terminal && self.lines.try_recv().is_ok() {}
        progress::beside(|| {
            // Where stderr cannot be written, the step is confirmed blindly or not at all.
            let _ = write!(std::io::stderr(), "{step}, then Enter: ");
            let _ = std::io::stderr().flush();
        });
        loop {
            if self.stop.load(Ordering::Relaxed) {
                return Err(INTERRUPTED.to_owned());
            }
            match self.lines.recv_timeout(LOOK) {
                Ok(()) => return Ok(()),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    return Err("stdin ended before this step was confirmed: run it on a terminal".to_owned());
                }
            }
        }
    }

    fn is_interrupted(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}
