//! How far long work is: a bar on a terminal with its unit and the time that is left, or a line of
//! what is watched; nothing elsewhere.

use std::sync::LazyLock;

use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

/// All bars: a line of the log is written between them.
static BARS: LazyLock<MultiProgress> = LazyLock::new(MultiProgress::new);

/// A bar over `count` pieces of work; `what` is done, in `unit` ("frames").
pub(crate) fn bar(count: u64, what: &str, unit: &str) -> ProgressBar {
    let bar = BARS.add(ProgressBar::new(count));
    let template = format!("{{msg}} {{bar:32}} {{pos}}/{{len}} {unit}, {{per_sec}}, {{eta}} left");
    if let Ok(style) = ProgressStyle::with_template(&template) {
        bar.set_style(style);
    }
    bar.set_message(what.to_owned());
    bar
}

/// A line that is written over again, beneath what else is written on the terminal; nothing
/// elsewhere.
pub(crate) fn line() -> ProgressBar {
    let line = BARS.add(ProgressBar::new_spinner());
    if let Ok(style) = ProgressStyle::with_template("{wide_msg}") {
        line.set_style(style);
    }
    line
}

/// Lines that are written over again, as [`line`].
pub(crate) fn page() -> ProgressBar {
    let page = BARS.add(ProgressBar::new_spinner());
    if let Ok(style) = ProgressStyle::with_template("{msg}") {
        page.set_style(style);
    }
    page
}

/// Does something that writes on the terminal, with the bars out of its way.
pub(crate) fn beside<T>(write: impl FnOnce() -> T) -> T {
    BARS.suspend(write)
}
