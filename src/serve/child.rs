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
/// Memory that a job may have, MiB: twenty times what a nose of 3072 × 2048 px takes, and a model
/// of 16 MiB; two jobs at a time.
const JOB_MIB: u64 = 2048;
/// Memory that a simulated run may have, MiB: frames of 8192 × 8192 px on all cores; two at a time.
pub(super) const RUN_MIB: u64 = 8192;
/// Warnings of a child that are kept.
const MOST_WARNINGS: usize = 20;

/// What a child that ran to its end has left.
#[derive(Debug, Default)]
pub(super) struct Ended {
    /// Its exit code; none where it was ended.
    pub exit: Option<i32>,
    /// The end of its log in words, without its warnings.
    pub words: String,
    /// What it warned of.
    pub warnings: Vec<String>,
}

impl Ended {
    /// Adds a line of the log: a warning, or words.
    fn add(&mut self, line: &str) {
        let line = line.trim_start();
        match line.strip_prefix("WARN ") {
            Some(warning) if self.warnings.len() < MOST_WARNINGS => {
                let mut words = String::new();
                add_words(&mut words, warning);
                self.warnings.push(words);
            }
            Some(_) => {}
            None => {
                let levels = ["ERROR ", "INFO ", "Error: "];
                let words = levels.iter().find_map(|level| line.strip_prefix(level));
                add_words(&mut self.words, words.unwrap_or(line));
            }
        }
    }
}

/// A child with its output, line by line.
pub(super) struct Running {
    pub child: Child,
    pub out: Lines<BufReader<ChildStdout>>,
    pub err: Lines<BufReader<ChildStderr>>,
}

/// A program whose data (what it writes of its memory: not what a driver only reserves) are
/// limited, MiB. The shell sets the limit and becomes the program: its process is that of the
/// child.
#[cfg(unix)]
fn limited(program: &Path, mib: u64) -> Command {
    let mut command = Command::new("/bin/sh");
    // a limit that is lower already stays
    command.arg("-c").arg(format!("ulimit -d {} 2>/dev/null; exec \"$0\" \"$@\"", mib * 1024)).arg(program);
    command
}

#[cfg(not(unix))]
fn limited(program: &Path, _mib: u64) -> Command {
    Command::new(program)
}

/// Starts this program with arguments, where stated with limited memory, MiB; it is killed when it
/// is dropped.
///
/// # Errors
/// Where the system starts none.
pub(super) fn start(arguments: &[String], memory_mib: Option<u64>) -> Result<Running, String> {
    let program: PathBuf = std::env::current_exe().map_err(|e| e.to_string())?;
    let mut command = match memory_mib {
        Some(mib) => limited(&program, mib),
        None => Command::new(&program),
    };
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
    let mut command = limited(&program, JOB_MIB);
    command.args(arguments).env("NO_COLOR", "1").current_dir(folder).kill_on_drop(true);
    command.stdin(Stdio::null()).stdout(out).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|e| e.to_string())?;
    let Some(err) = child.stderr.take() else { return Err("its log is not connected".into()) };
    let mut ended = Ended::default();
    let followed = async {
        let mut err = lines(err);
        while let Ok(Some(line)) = err.next_line().await {
            ended.add(&line);
        }
        child.wait().await
    };
    match tokio::time::timeout(LONGEST, followed).await {
        Ok(status) => ended.exit = status.map_err(|e| e.to_string())?.code(),
        Err(_) => ended.words = format!("ended after {} s", LONGEST.as_secs()),
    }
    Ok(ended)
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

#[cfg(test)]
mod tests {
    use super::{Ended, add_words};

    #[test]
    fn warnings_stand_apart_from_what_is_refused() {
        let mut ended = Ended::default();
        for line in
            [" WARN the depth is not compared", "Error:   × part.toml: corners[2]: out of reach", "  │ Z 12"]
        {
            ended.add(line);
        }
        assert_eq!(ended.words, "part.toml: corners[2]: out of reach Z 12");
        assert_eq!(ended.warnings, ["the depth is not compared"]);
        let mut log = String::new();
        (0..1000).for_each(|k| add_words(&mut log, &format!("line {k}")));
        assert!(log.len() <= 2001 && log.ends_with("line 999"), "{}", log.len());
    }

    /// What the child's own shell states of its limit.
    #[cfg(unix)]
    #[test]
    fn a_child_has_the_memory_that_is_stated_and_no_more() {
        let mut command = super::limited(std::path::Path::new("/bin/sh"), 64).into_std();
        let said = command.args(["-c", "ulimit -d"]).output().unwrap();
        assert_eq!(String::from_utf8_lossy(&said.stdout).trim(), (64 * 1024).to_string());
    }
}
