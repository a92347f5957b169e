//! The command of an alarm.

use std::process::Child;
use std::time::{Duration, Instant};

use super::shell;

/// How long the command is waited for at the end: longer than a request to a control takes, shorter
/// than a person waits for a program that was ended.
const PATIENCE: Duration = Duration::from_secs(5);
/// Time between two looks at it.
const LOOK: Duration = Duration::from_millis(20);

/// The command, until it was run.
#[derive(Debug)]
pub(super) struct OnAlarm {
    command: Option<String>,
    running: Option<Child>,
}

impl OnAlarm {
    /// A command of the shell, where one is given.
    pub(super) fn new(command: Option<String>) -> Self {
        Self { command, running: None }
    }

    /// Starts the command, and does not wait for it.
    pub(super) fn start(&mut self, cause: &str) {
        let Some(text) = self.command.take() else { return };
        match shell::command(&text).env("SHADOWGAUGE_ALARM", cause).spawn() {
            Ok(child) => self.running = Some(child),
            Err(error) => tracing::error!("--on-alarm \"{text}\" cannot be run: {error}"),
        }
    }

    /// Waits for the command; reports one that failed, or that does not end.
    pub(super) fn finish(&mut self) {
        let Some(mut child) = self.running.take() else { return };
        let begun = Instant::now();
        while begun.elapsed() < PATIENCE {
            match child.try_wait() {
                Ok(None) => std::thread::sleep(LOOK),
                Ok(Some(status)) if status.success() => return,
                Ok(Some(status)) => return tracing::error!("--on-alarm ended with {status}"),
                Err(error) => return tracing::error!("--on-alarm: {error}"),
            }
        }
        tracing::error!("--on-alarm still runs after {PATIENCE:?}; it is left to itself");
    }
}
