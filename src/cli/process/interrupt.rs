//! Ctrl-C. In: the words that a command ends with when it is interrupted, or that it asks for
//! itself. Out: an end with exit code 130 after these words, or a flag that the command reads.
//!
//! A command that does neither is ended by the signal, as every program is.

use std::io::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock, Mutex, Once, PoisonError};

use super::end_at_once;

/// Exit code of a command that is interrupted: a shell's, 128 + SIGINT.
pub(crate) const INTERRUPTED: u8 = 130;

static REQUESTED: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);
static WORDS: Mutex<Option<String>> = Mutex::new(None);
static INSTALLED: Once = Once::new();

/// From here on Ctrl-C ends the program with exit code 130 after these words.
pub(crate) fn end_with(words: String) {
    *WORDS.lock().unwrap_or_else(PoisonError::into_inner) = Some(words);
    install();
}

/// What becomes true at Ctrl-C. From the first call on the command that asks ends by itself; a
/// second Ctrl-C ends it at once.
pub(crate) fn requested() -> Arc<AtomicBool> {
    install();
    Arc::clone(&REQUESTED)
}

fn install() {
    INSTALLED.call_once(|| {
        if let Err(error) = ctrlc::set_handler(on_interrupt) {
            tracing::debug!("Ctrl-C is not caught: {error}");
        }
    });
}

/// Runs in a thread of its own, not in a signal handler.
fn on_interrupt() {
    let is_second = REQUESTED.swap(true, Ordering::Relaxed);
    let words = WORDS.lock().unwrap_or_else(PoisonError::into_inner).take();
    if let Some(words) = &words {
        // Where stderr cannot be written, only the exit code remains.
        let _ = writeln!(std::io::stderr(), "\n{words}");
    }
    if is_second || words.is_some() {
        end_at_once(INTERRUPTED);
    }
}

/// The command line of this process, as a shell takes it.
pub(crate) fn command_line() -> String {
    let words: Vec<String> = std::env::args_os().map(|word| quoted(&word.to_string_lossy())).collect();
    words.join(" ")
}

/// A word of a shell's line, in quotes where it needs them.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "_-./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_where_a_shell_needs_it() {
        assert_eq!(quoted("out/small-1.toml"), "out/small-1.toml");
        assert_eq!(quoted("my shaft.toml"), "'my shaft.toml'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        assert_eq!(quoted(""), "''");
    }
}
