//! What a command shows on a terminal besides its output: its log on stderr, where a warning that
//! repeats is written once (`log`), and how far it is (`progress`). Both share the terminal's
//! lines.

pub(super) mod log;
pub(crate) mod progress;
