//! `shadowgauge reproduce …`: a paper's figures beside ours.

use clap::Subcommand;

use super::reproduce_000::{self, Reproduce000Args};
use super::reproduce_003::{self, Reproduce003Args};
use super::{CommandResult, Failure, Outcome};
use crate::report::html::Page;
use crate::studies::reproduction::{Row, Verdict};

/// The papers.
#[derive(Debug, Subcommand)]
pub enum Paper {
    /// Least-squares compensation of a single shaft through macro variables.
    #[command(name = "000")]
    P000(Reproduce000Args),
    /// Slender shaft: forces, deflection, choice of cutting data, PID compensation (Xue, Miao, Xue 2023).
    #[command(name = "003")]
    P003(Reproduce003Args),
}

/// Reproduces a paper.
///
/// # Errors
/// As the paper's command.
pub fn run(paper: &Paper) -> CommandResult {
    match paper {
        Paper::P000(args) => reproduce_000::run(args),
        Paper::P003(args) => reproduce_003::run(args),
    }
}

fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Reproduced => "reproduced",
        Verdict::Consistent => "consistent",
        Verdict::Contradiction => "contradiction",
    }
}

/// Prints the rows as a JSON array or as a table.
pub(super) fn print(rows: &[Row], json: bool) -> CommandResult {
    if json {
        say_line!("{}", serde_json::to_string_pretty(rows).map_err(Failure::fail)?);
        return Ok(Outcome::Done);
    }
    say_line!("{:<13} {:<28} {:>12} {:>12}  quantity and reason", "verdict", "id", "paper", "ours");
    for row in rows {
        let paper = row.paper.map_or("-".to_owned(), short);
        let line = format!("{} [{}]", row.quantity, row.unit).replace(" []", "");
        say_line!(
            "{:<13} {:<28} {:>12} {:>12}  {line}: {}",
            word(row.verdict),
            row.id,
            paper,
            short(row.ours),
            row.reason
        );
    }
    let count = |verdict| rows.iter().filter(|row| row.verdict == verdict).count();
    say_line!(
        "{} rows: {} reproduced, {} consistent, {} contradictions in the paper",
        rows.len(),
        count(Verdict::Reproduced),
        count(Verdict::Consistent),
        count(Verdict::Contradiction)
    );
    Ok(Outcome::Done)
}

/// A number in about five digits.
fn short(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || (1e-3..1e6).contains(&size) { format!("{value:.5}") } else { format!("{value:.3e}") }
}

/// The rows on a page, a table for each part of the paper: the words in the first column, so that a page is wide enough.
pub(super) fn tables(page: &mut Page, rows: &[Row], parts: &[(&str, &[&str])]) {
    let cells = |row: &Row| {
        let unit = if row.unit.is_empty() { String::new() } else { format!(" [{}]", row.unit) };
        vec![
            format!("{}: {}{unit}: {}", row.id, row.quantity, row.reason),
            row.paper.map_or("-".to_owned(), short),
            short(row.ours),
            row.difference.map_or("-".to_owned(), short),
            word(row.verdict).to_owned(),
        ]
    };
    for (heading, prefixes) in parts {
        // A prefix that ends in a blank means that very id.
        let named = |row: &&Row| prefixes.iter().any(|prefix| format!("{} ", row.id).starts_with(prefix));
        let mine = rows.iter().filter(named);
        let cells: Vec<Vec<String>> = mine.map(cells).collect();
        if !cells.is_empty() {
            page.heading(heading);
            page.table(&["quantity and reason", "paper", "ours", "difference", "verdict"], &cells);
        }
    }
}
