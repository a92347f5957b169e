//! What a command writes: its results to stdout (`output`); on stderr its log, where a warning that
//! repeats is written once (`log`), and how far it is (`progress`), which share the terminal's
//! lines.

#[macro_use]
pub(super) mod output;

pub(super) mod log;
pub(super) mod progress;
