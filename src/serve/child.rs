//! This program as a child: a run, or a source that is watched.

use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;

use tokio::io::{AsyncBufReadExt as _, AsyncRead, BufReader, Lines};
use tokio::process::{Child, ChildStderr, ChildStdout, Command};

/// Longest line that is passed on, bytes: a frame's is below 2 KiB, a budget's below 16.
pub(super) const LONGEST_LINE: usize = 64 * 1024;

/// Characters of the log's end that are kept: the longest refusal with its help.
const LOG_END: usize = 2000;
/// Time that a program, a reading or a contour may take: a hundred times what one takes.
const LONGEST: Duration = Duration::from_secs(60);

/// What a child that ran to its end has left.
#[derive(Debug)]
pub(super) struct Ended {
    /// Its exit code; none where it was ended.
    pub exit: Option<i32>,
    /// The end of its log in words.
    pub words: String,
}

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

/// Runs this program in a folder to its end; stdout goes into the file `stdout` there.
///
/// # Errors
/// Where the system starts none.
pub(super) async fn finished(arguments: &[String], folder: &Path) -> Result<Ended, String> {
    let program = std::env::current_exe().map_err(|e| e.to_string())?;
    let out = std::fs::File::create(folder.join("stdout")).map_err(|e| e.to_string())?;
    let mut command = Command::new(program);
    command.args(arguments).env("NO_COLOR", "1").current_dir(folder).kill_on_drop(true);
    command.stdin(Stdio::null()).stdout(out).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|e| e.to_string())?;
    let Some(err) = child.stderr.take() else { return Err("its log is not connected".into()) };
    let mut words = String::new();
    let followed = async {
        let mut err = lines(err);
        while let Ok(Some(line)) = err.next_line().await {
            add_words(&mut words, &line);
        }
        child.wait().await
    };
    let ended = tokio::time::timeout(LONGEST, followed).await;
    match ended {
        Ok(status) => Ok(Ended { exit: status.map_err(|e| e.to_string())?.code(), words }),
        Err(_) => Ok(Ended { exit: None, words: format!("ended after {} s", LONGEST.as_secs()) }),
    }
}

/// Adds a line of the log to its end, without what draws it on a terminal.
pub(super) fn add_words(log: &mut String, line: &str) {
    let words: Vec<&str> = line.split(|c: char| c.is_whitespace() || "×│├╰─▶".contains(c)).collect();
    for word in words.into_iter().filter(|word| !word.is_empty()) {
        if !log.is_empty() {
            log.push(' ');
        }
        log.push_str(word);
    }
    if let Some((start, _)) = log.char_indices().rev().nth(LOG_END) {
        log.drain(..start);
    }
}
