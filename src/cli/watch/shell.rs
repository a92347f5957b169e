//! Commands of the user, run by the shell.

use std::process::{Command, Stdio};

/// A command of the shell, with stdin closed and stdout dropped: stdout has results.
pub(super) fn command(text: &str) -> Command {
    let (shell, option) = if cfg!(windows) { ("cmd", "/C") } else { ("sh", "-c") };
    let mut command = Command::new(shell);
    command.args([option, text]).stdin(Stdio::null()).stdout(Stdio::null());
    command
}
