//! `exit_codes.md`: how a command ends.

use crate::cli::failure::EXIT_CODES;

const START: &str = "# Exit codes

<!-- Written by `shadowgauge reference`; do not edit. -->

What a script may rely on. Data stand on stdout, words on stderr.

| code | meaning |
|---|---|
";

/// The page.
pub(crate) fn page() -> String {
    let rows = EXIT_CODES.iter().map(|(code, meaning)| format!("| {code} | {meaning} |\n"));
    START.to_owned() + &rows.collect::<String>()
}
