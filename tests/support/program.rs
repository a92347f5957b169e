//! Runs of the program with arguments, and their output.
#![allow(dead_code, reason = "not every test uses every helper")]

use std::ffi::OsStr;
use std::path::PathBuf;
use std::process::{Command, Output};

/// The program: beside the test's own executable, where Cargo puts both.
pub fn path() -> PathBuf {
    if let Some(path) = option_env!("CARGO_BIN_EXE_shadowgauge") {
        return path.into();
    }
    let test = std::env::current_exe().expect("a test has a path");
    let program = test.ancestors().nth(2).expect("target/PROFILE/deps").join("shadowgauge");
    assert!(program.exists(), "{} is not built: cargo build, or cargo nextest run", program.display());
    program
}

/// Runs the program without colours.
pub fn shadowgauge<S: AsRef<OsStr>>(arguments: impl IntoIterator<Item = S>) -> Output {
    let mut command = Command::new(path());
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
