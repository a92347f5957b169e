//! Rows of a reproduction as text, as JSON and on a page.

use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::report::html::Page;
use crate::studies::reproduction::{Row, Verdict};

/// Prints the rows as a JSON array or as a table. Exit 1 where a figure is missed without a known
/// reason.
pub(super) fn print(rows: &[Row], json: bool) -> CommandResult {
    let missed = rows.iter().filter(|row| row.is_unexplained_miss()).count();
    let outcome = if missed == 0 { Outcome::Done } else { Outcome::OutOfTolerance };
    if json {
        say_line!("{}", serde_json::to_string_pretty(rows).map_err(Failure::fail)?);
        return Ok(outcome);
    }
    say_line!("{:<16} {:<28} {:>12} {:>12}  quantity and reason", "verdict", "id", "paper", "ours");
    for row in rows {
        let paper = row.paper.map_or("-".to_owned(), short);
        say_line!(
            "{:<16} {:<28} {:>12} {:>12}  {}",
            row.verdict.words(),
            row.id,
            paper,
            short(row.ours),
            sentence(row)
        );
    }
    say_line!("{}", summary(rows));
    Ok(outcome)
}

/// Quantity, reason, tolerance and missing data.
fn sentence(row: &Row) -> String {
    let unit = if row.unit.is_empty() { String::new() } else { format!(" [{}]", row.unit) };
    let mut text = format!("{}{unit}: {}", row.quantity, row.reason);
    if let Some((from, to)) = row.accepted_from.zip(row.accepted_to).filter(|_| row.missing.is_none()) {
        text += &match (from.is_finite(), to.is_finite()) {
            (true, true) => format!("; accepted {} to {}", short(from), short(to)),
            (true, false) => format!("; accepted from {}", short(from)),
            _ => format!("; accepted up to {}", short(to)),
        };
    }
    if let Some(missing) = &row.missing {
        text += &format!("; the paper lacks {missing}");
    }
    if let Some(reason) = &row.known_miss {
        text += &format!("; known: {reason}");
    }
    text
}

/// How many rows have each verdict.
pub(super) fn summary(rows: &[Row]) -> String {
    let count = |verdict| rows.iter().filter(|row| row.verdict == verdict).count();
    let counts: Vec<String> =
        Verdict::ALL.iter().map(|&verdict| format!("{} {}", count(verdict), verdict.words())).collect();
    let known = rows.iter().filter(|row| row.known_miss.is_some()).count();
    format!("{} rows: {} ({known} of the misses known)", rows.len(), counts.join(", "))
}

/// Explanation of the verdicts, for a page.
pub(super) const VERDICTS: &str = "Every figure of the paper beside ours, computed now; the verdict follows from figure, ours and the range accepted. \
    Reproduced: a prediction not fitted to the figure. Consistent: a fit to it, an identity or an input. Contradiction: the \
    paper's own figures and equations exclude each other, shown without a constant of ours. Undetermined: the paper lacks the \
    data. Not reproduced: ours misses; known misses give their reason. Not in the paper: ours alone.";

/// A number in about five digits.
fn short(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || (1e-3..1e6).contains(&size) { format!("{value:.5}") } else { format!("{value:.3e}") }
}

/// The rows on a page, a table for each part of the paper: with the text in the first column, so
/// that the table fits on a page.
pub(super) fn tables(page: &mut Page, rows: &[Row], parts: &[(&str, &[&str])]) {
    let cells = |row: &Row| {
        vec![
            format!("{}: {}", row.id, sentence(row)),
            row.paper.map_or("-".to_owned(), short),
            short(row.ours),
            row.difference.map_or("-".to_owned(), short),
            row.verdict.words().to_owned(),
        ]
    };
    for (heading, prefixes) in parts {
        // A prefix that ends in a blank is an exact id.
        let named = |row: &&Row| prefixes.iter().any(|prefix| format!("{} ", row.id).starts_with(prefix));
        let mine = rows.iter().filter(named);
        let cells: Vec<Vec<String>> = mine.map(cells).collect();
        if !cells.is_empty() {
            page.heading(heading);
            page.table(&["quantity and reason", "paper", "ours", "difference", "verdict"], &cells);
        }
    }
}
