//! Markdown: cells of tables, anchors of headings.

/// Text for a cell of a table: one line, without what Markdown would take for a border or a tag.
pub(crate) fn cell(text: &str) -> String {
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ").replace('|', "\\|");
    let outside_code = |(k, part): (usize, &str)| match k % 2 {
        0 => part.replace('<', "&lt;").replace('[', "\\["),
        _ => part.to_owned(),
    };
    line.split('`').enumerate().map(outside_code).collect::<Vec<_>>().join("`")
}

/// A row of a table.
pub(crate) fn row(cells: &[String]) -> String {
    format!("| {} |\n", cells.join(" | "))
}

/// The anchor of a heading that occurs once.
pub(crate) fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.collect::<String>().to_lowercase().replace(' ', "-")
}
