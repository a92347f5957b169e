//! The log on stderr. In: events of the program. Out: a line each; a warning that repeats, for
//! another frame or pass, is written once and counted, and the count is written at the end. Of a
//! long series whose warnings all differ the first [`MOST_KINDS`] are written, and how many more
//! there were. With -v, or RUST_LOG, every line is written.

use std::collections::HashMap;
use std::io::{IsTerminal as _, Result, Write, stderr};
use std::sync::{LazyLock, Mutex, PoisonError};

use tracing::{Level, Metadata};
use tracing_subscriber::EnvFilter;
use tracing_subscriber::fmt::MakeWriter;

use super::progress::beside;

/// Most kinds of warnings that are written and kept: some screens, more than a person reads of one
/// command; a third of a megabyte.
const MOST_KINDS: usize = 1000;

/// Starts the log; `verbose` is the number of -v.
pub(crate) fn start(verbose: u8) {
    let level = ["shadowgauge=warn", "shadowgauge=info", "shadowgauge=debug"][usize::from(verbose.min(2))];
    let by_environment = EnvFilter::try_from_default_env();
    let says_all = verbose > 0 || by_environment.is_ok();
    let colour = std::env::var_os("NO_COLOR").is_none() && stderr().is_terminal();
    tracing_subscriber::fmt()
        .with_env_filter(by_environment.unwrap_or_else(|_| level.into()))
        .with_writer(Log { says_all })
        .with_ansi(colour)
        .log_internal_errors(false)
        .without_time()
        .with_target(false)
        .init();
}

/// Writes how often the warnings that repeated were left out.
pub(crate) fn finish() {
    let Kinds { counts, others } = std::mem::take(&mut *KINDS.lock().unwrap_or_else(PoisonError::into_inner));
    let mut repeated: Vec<(String, Count)> =
        counts.into_iter().filter(|(_, count)| count.left_out > 0).collect();
    repeated.sort_by_key(|(_, count)| count.order);
    for (text, Count { left_out, .. }) in repeated {
        let times = if left_out == 1 { "once more" } else { "times more" };
        let number = if left_out == 1 { String::new() } else { format!("{left_out} ") };
        // Where stderr cannot be written, the exit code remains.
        let _ = writeln!(stderr(), " WARN {number}{times} (-v shows each): {text}");
    }
    if others > 0 {
        let _ = writeln!(
            stderr(),
            " WARN {others} more, unlike the {MOST_KINDS} kinds of warnings before them (-v shows each)"
        );
    }
}

/// How often a warning occurred after its first time.
#[derive(Clone, Copy, Debug)]
struct Count {
    order: usize,
    left_out: usize,
}

/// The warnings so far.
#[derive(Debug, Default)]
struct Kinds {
    counts: HashMap<String, Count>,
    /// Warnings of further kinds than are kept.
    others: usize,
}

static KINDS: LazyLock<Mutex<Kinds>> = LazyLock::new(Mutex::default);

impl Kinds {
    /// Whether a warning is the first of its kind, and of the kinds that are written; others are
    /// counted.
    fn is_first(&mut self, line: &str) -> bool {
        let (kind, order) = (kind(line), self.counts.len());
        if let Some(count) = self.counts.get_mut(kind) {
            count.left_out += 1;
            return false;
        }
        if order == MOST_KINDS {
            self.others += 1;
            return false;
        }
        self.counts.insert(kind.to_owned(), Count { order, left_out: 0 });
        true
    }
}

/// As [`Kinds::is_first`], of this command.
fn is_first(line: &str) -> bool {
    KINDS.lock().unwrap_or_else(PoisonError::into_inner).is_first(line)
}

/// A warning without the frame or pass that it begins or ends with.
fn kind(line: &str) -> &str {
    let text = line.split_once("WARN").map_or(line, |(_, text)| text);
    // The codes of colours behind the level.
    let text = text.strip_prefix("\u{1b}[0m").unwrap_or(text).trim();
    let is_count = |word: &str| !word.is_empty() && word.bytes().all(|b| b.is_ascii_digit());
    let text = text.rsplit_once(" pass=").filter(|(_, pass)| is_count(pass)).map_or(text, |(text, _)| text);
    let is_of_one = text.starts_with("frame ") || text.starts_with("pass ");
    text.split_once(": ").filter(|_| is_of_one).map_or(text, |(_, text)| text)
}

struct Log {
    says_all: bool,
}

/// Takes a line of the log.
struct Line {
    says_all: bool,
}

impl<'a> MakeWriter<'a> for Log {
    type Writer = Line;

    fn make_writer(&'a self) -> Line {
        Line { says_all: true }
    }

    fn make_writer_for(&'a self, event: &Metadata<'_>) -> Line {
        Line { says_all: self.says_all || *event.level() != Level::WARN }
    }
}

impl Write for Line {
    fn write(&mut self, line: &[u8]) -> Result<usize> {
        if self.says_all || is_first(&String::from_utf8_lossy(line)) {
            beside(|| stderr().write_all(line))?;
        }
        Ok(line.len())
    }

    fn flush(&mut self) -> Result<()> {
        stderr().flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warning_is_known_by_what_it_says_not_by_its_frame() {
        assert_eq!(kind(" WARN frame 000012: too dark\n"), "too dark");
        assert_eq!(kind("\u{1b}[33m WARN\u{1b}[0m frame a.png: too dark\n"), "too dark");
        assert_eq!(kind(" WARN the chip is thin pass=3\n"), "the chip is thin");
        assert_eq!(kind(" WARN job.toml: an aim at a limit\n"), "job.toml: an aim at a limit");
    }

    #[test]
    fn the_second_of_a_kind_is_counted() {
        let mut kinds = Kinds::default();
        assert!(kinds.is_first(" WARN frame 1: a test of the count\n"));
        assert!(!kinds.is_first(" WARN frame 2: a test of the count\n"));
        assert!(kinds.is_first(" WARN frame 2: another test of the count\n"));
    }

    #[test]
    fn warnings_that_all_differ_take_bounded_memory() {
        let mut kinds = Kinds::default();
        let written = (0..5 * MOST_KINDS).filter(|k| kinds.is_first(&format!(" WARN {k} um off\n"))).count();
        assert_eq!((written, kinds.counts.len(), kinds.others), (MOST_KINDS, MOST_KINDS, 4 * MOST_KINDS));
        // One of the kinds that are kept is still counted as such.
        assert!(!kinds.is_first(" WARN 7 um off\n"));
        assert_eq!((kinds.counts["7 um off"].left_out, kinds.others), (1, 4 * MOST_KINDS));
    }
}
