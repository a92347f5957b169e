//! A thermometer that is read by a command of the shell: `--temperature-cmd CMD`.

use std::io::Read as _;
use std::process::{Child, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use super::shell;
use crate::cli::measure::temperature_args::UNSTATED_K;
use crate::measurement::TemperatureSample;
use crate::source::host_t_ns;

/// Time from one reading to the next: half of what a temperature holds for.
const PERIOD: Duration = Duration::from_secs(5);
/// Longest time of a command: what a temperature holds for. One that takes longer is ended.
const LONGEST: Duration = Duration::from_secs(10);
/// Time between two looks at the command.
const LOOK: Duration = Duration::from_millis(20);
/// Most bytes of what it prints.
const MOST_BYTES: u64 = 65_536;

/// A thermometer, read on a thread of its own until it is dropped.
#[derive(Debug)]
pub(super) struct Thermometer {
    readings: Receiver<Result<TemperatureSample, String>>,
    is_over: Arc<AtomicBool>,
}

impl Thermometer {
    /// Reads it by a command from now on.
    ///
    /// # Errors
    /// A system without another thread.
    pub(super) fn begin(command: String) -> std::io::Result<Self> {
        let (to, readings) = channel();
        let is_over = Arc::<AtomicBool>::default();
        let ended = Arc::clone(&is_over);
        let read = move || read_on(&command, &to, &ended);
        std::thread::Builder::new().name("thermometer".to_owned()).spawn(read)?;
        Ok(Self { readings, is_over })
    }

    /// The readings since the last call, or why one failed.
    pub(super) fn readings(&self) -> impl Iterator<Item = Result<TemperatureSample, String>> + '_ {
        self.readings.try_iter()
    }

    /// Waits for the first reading, so that the first frame has a temperature.
    pub(super) fn first(&self) -> Result<TemperatureSample, String> {
        let none = |_| Err(format!("no temperature within {} s", LONGEST.as_secs()));
        self.readings.recv_timeout(LONGEST + LOOK * 10).unwrap_or_else(none)
    }
}

impl Drop for Thermometer {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
    }
}

fn read_on(command: &str, to: &Sender<Result<TemperatureSample, String>>, is_over: &AtomicBool) {
    let ends = || is_over.load(Ordering::Relaxed);
    while !ends() {
        let begun = Instant::now();
        // The value is at most as old as the start of the command.
        let t_ns = host_t_ns();
        if to.send(printed(command, is_over).and_then(|text| sample(t_ns, &text))).is_err() {
            return;
        }
        while begun.elapsed() < PERIOD && !ends() {
            std::thread::sleep(LOOK);
        }
    }
}

/// What the command prints.
fn printed(command: &str, is_over: &AtomicBool) -> Result<String, String> {
    let spawned = shell::command(command).stdout(Stdio::piped()).spawn();
    let mut child = spawned.map_err(|error| error.to_string())?;
    waited(&mut child, is_over)?;
    let mut text = Vec::new();
    if let Some(stdout) = child.stdout.take() {
        stdout.take(MOST_BYTES).read_to_end(&mut text).map_err(|error| error.to_string())?;
    }
    Ok(String::from_utf8_lossy(&text).into_owned())
}

fn waited(child: &mut Child, is_over: &AtomicBool) -> Result<(), String> {
    let begun = Instant::now();
    while begun.elapsed() < LONGEST && !is_over.load(Ordering::Relaxed) {
        match child.try_wait() {
            Ok(None) => std::thread::sleep(LOOK),
            Ok(Some(status)) if status.success() => return Ok(()),
            Ok(Some(status)) => return Err(format!("it ended with {status}")),
            Err(error) => return Err(error.to_string()),
        }
    }
    // It may have ended by itself meanwhile; either way it is waited for, so that none is left.
    let _ = child.kill();
    let _ = child.wait();
    Err(format!("it did not end within {} s", LONGEST.as_secs()))
}

/// A sample of the last line printed: `part_c`, and where they are known `limit_k`, `head_c` and
/// `scale_c` after commas.
fn sample(t_ns: u64, text: &str) -> Result<TemperatureSample, String> {
    let line = text.lines().map(str::trim).rfind(|line| !line.is_empty()).unwrap_or("");
    let wrong = || {
        format!(
            "it printed {line:?}; the part's temperature is right, \"20.4\", with limits and the head's \"20.4,0.2,24.1\""
        )
    };
    let fields: Vec<&str> = line.split(',').map(str::trim).collect();
    let value = |text: &str| text.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(wrong);
    let (part, limit, head, scale) = match fields[..] {
        [part] => (part, "", "", ""),
        [part, limit] => (part, limit, "", ""),
        [part, limit, head] => (part, limit, head, ""),
        [part, limit, head, scale] => (part, limit, head, scale),
        _ => return Err(wrong()),
    };
    let given = |text: &str| if text.is_empty() { Ok(None) } else { value(text).map(Some) };
    Ok(TemperatureSample {
        t_ns,
        part_c: value(part)?,
        limit_k: given(limit)?.unwrap_or(UNSTATED_K),
        head_c: given(head)?,
        scale_c: given(scale)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_line_is_the_reading() {
        let of = |text| sample(7, text).map(|s| (s.part_c, s.limit_k, s.head_c));
        assert_eq!(of("20.5"), Ok((20.5, UNSTATED_K, None)));
        assert_eq!(of("waiting\n 20.5 , 0.2 , 24\n\n"), Ok((20.5, 0.2, Some(24.0))));
        assert_eq!(of("20.5,,24"), Ok((20.5, UNSTATED_K, Some(24.0))));
        assert_eq!(sample(7, "20.5,,24,22.5").map(|s| s.scale_c), Ok(Some(22.5)));
        for text in ["", "warm", "20,5,1,1,1", "nan", "20.5,x"] {
            assert!(of(text).unwrap_err().contains("20.4,0.2,24.1"), "{text:?}");
        }
    }

    #[test]
    fn a_command_is_read_and_its_failure_named() {
        if cfg!(windows) {
            println!("SKIPPED: the commands are of sh");
            return;
        }
        let first = |command: &str| Thermometer::begin(command.to_owned()).unwrap().first();
        let read = first("echo 21.5,0.1").unwrap();
        assert!((read.part_c, read.limit_k) == (21.5, 0.1) && read.t_ns > 0);
        assert!(first("exit 3").unwrap_err().contains('3'));
    }
}
