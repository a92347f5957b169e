//! Runs of the program with arguments, and their output.
#![allow(dead_code, reason = "not every test uses every helper")]

use std::ffi::OsStr;
use std::process::{Command, Output};

/// Runs the program without colours.
pub fn shadowgauge<S: AsRef<OsStr>>(arguments: impl IntoIterator<Item = S>) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_shadowgauge"));
    command.args(arguments).env("NO_COLOR", "1").output().expect("the program runs")
}

/// Stdout or stderr as text.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The text of a command on stderr, without the line breaks and rulers of a narrow terminal.
pub fn said(output: &Output) -> String {
    let text = text(&output.stderr);
    let words = text.split(|c: char| c.is_whitespace() || c == '│').filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join(" ")
}

/// The document on stdout.
pub fn json(output: &Output) -> serde_json::Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {}", said(output)))
}
