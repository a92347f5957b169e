//! This program as a child: a run, or a source that is watched.

use std::path::PathBuf;
use std::process::Stdio;

use tokio::io::{AsyncBufReadExt as _, AsyncRead, BufReader, Lines};
use tokio::process::{Child, ChildStderr, ChildStdout, Command};

/// Longest line that is passed on, bytes: a frame's is below 2 KiB, a budget's below 16.
pub(super) const LONGEST_LINE: usize = 64 * 1024;

/// A child with its output, line by line.
pub(super) struct Running {
    pub child: Child,
    pub out: Lines<BufReader<ChildStdout>>,
    pub err: Lines<BufReader<ChildStderr>>,
}

/// Starts this program with arguments; it is killed when it is dropped.
///
/// # Errors
/// Where the system starts none.
pub(super) fn start(arguments: &[String]) -> Result<Running, String> {
    let program: PathBuf = std::env::current_exe().map_err(|e| e.to_string())?;
    let mut command = Command::new(program);
    command.args(arguments).env("NO_COLOR", "1").kill_on_drop(true);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|e| e.to_string())?;
    let (Some(out), Some(err)) = (child.stdout.take(), child.stderr.take()) else {
        return Err("its output is not connected".into());
    };
    Ok(Running { child, out: lines(out), err: lines(err) })
}

fn lines<R: AsyncRead + Unpin>(from: R) -> Lines<BufReader<R>> {
    BufReader::new(from).lines()
}
