//! Processes that measure the scenes with one threshold replaced: this program, started once a
//! variant.
//!
//! The scenes go in through stdin, so that nothing is left on a disk however a study ends; one line
//! of JSON comes out. A process that crashes, or that takes far longer than the default's, has an
//! ending that names it.

use std::io::Write as _;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::studies::limits::{Measured, Variant};

/// Interval at which a process is looked after.
const LOOK: Duration = Duration::from_millis(10);

/// What a process prints.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Printed {
    /// What it measured.
    pub(super) measured: Measured,
    /// CPU time of the measurement, s; none where the system does not state it.
    pub(super) cpu_s: Option<f64>,
}

/// How a process ended.
#[derive(Debug)]
pub(super) enum Ending {
    /// With its results.
    Measured(Printed),
    /// Without: how, in a few words.
    Crashed(String),
    /// It was ended after the time limit.
    TimedOut,
}

/// Measures the scenes in a process of their own, with a threshold replaced or with none.
///
/// # Errors
/// Where no process can be started.
pub(super) fn run(
    scenes: &[u8],
    variant: Option<&Variant>,
    time_limit: Option<Duration>,
) -> std::io::Result<Ending> {
    let mut command = Command::new(std::env::current_exe()?);
    command.args(["study", "limits", "--measure"]);
    if let Some(Variant { name, value, .. }) = variant {
        command.arg(format!("--variant={name}={value}"));
    }
    // One thread each: the processes share the cores among them.
    command.env("RAYON_NUM_THREADS", "1").env("NO_COLOR", "1").env_remove("RUST_LOG");
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn()?;
    let (input, output, errors) = (child.stdin.take(), child.stdout.take(), child.stderr.take());
    std::thread::scope(|scope| {
        // A process that ends early takes no more input: its ending is what counts.
        scope.spawn(move || input.map(|mut pipe| pipe.write_all(scenes)));
        let output = scope.spawn(move || text(output));
        let errors = scope.spawn(move || text(errors));
        let status = wait(&mut child, time_limit)?;
        let (output, errors) = (output.join().unwrap_or_default(), errors.join().unwrap_or_default());
        Ok(status.map_or(Ending::TimedOut, |status| ending(status, &output, &errors)))
    })
}

/// All of a pipe as text.
fn text(pipe: Option<impl std::io::Read>) -> String {
    let mut bytes = Vec::new();
    // What cannot be read of a process that failed is missing from its last words.
    let _ = pipe.map(|mut pipe| pipe.read_to_end(&mut bytes));
    String::from_utf8_lossy(&bytes).into_owned()
}

/// How the process ended; none where it was ended after the limit.
fn wait(child: &mut Child, time_limit: Option<Duration>) -> std::io::Result<Option<ExitStatus>> {
    let began = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if time_limit.is_some_and(|limit| began.elapsed() > limit) {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        std::thread::sleep(LOOK);
    }
}

fn ending(status: ExitStatus, output: &str, errors: &str) -> Ending {
    match serde_json::from_str(output.trim()) {
        Ok(printed) if status.success() => Ending::Measured(printed),
        _ => Ending::Crashed(format!("{status}: {}", last_words(errors))),
    }
}

/// What a process wrote at its end, on one line.
fn last_words(errors: &str) -> String {
    let panicked = errors.lines().skip_while(|line| !line.contains("panicked at")).take(2);
    let mut words: Vec<&str> = panicked.collect();
    if words.is_empty() {
        words = errors.lines().rev().find(|line| !line.trim().is_empty()).into_iter().collect();
    }
    words.join(" ").chars().take(200).collect()
}

/// CPU time of this process so far, s: Linux states it a thread, in nanoseconds.
pub(super) fn cpu_s() -> Option<f64> {
    let mut sum = 0.0;
    for task in std::fs::read_dir("/proc/self/task").ok()? {
        let text = std::fs::read_to_string(task.ok()?.path().join("schedstat")).ok()?;
        sum += 1e-9 * text.split_whitespace().next()?.parse::<f64>().ok()?;
    }
    Some(sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn last_words_name_the_panic() {
        let errors = "note\nthread 'main' panicked at src/a.rs:1:2:\ndivided by zero\nnote: run with\n";
        assert_eq!(last_words(errors), "thread 'main' panicked at src/a.rs:1:2: divided by zero");
        assert_eq!(last_words("one\ntwo\n\n"), "two");
        assert_eq!(last_words(""), "");
    }
}
