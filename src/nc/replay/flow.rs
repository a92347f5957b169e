//! Lines of a program: without comments, and the targets of IF, WHILE and GOTO.

use std::collections::HashMap;

use crate::nc::dialect::Dialect;

/// A line without comments, upper case, with the text of an active comment.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Line {
    pub(super) text: String,
    /// Text of LinuxCNC's `(ABORT,…)`.
    pub(super) abort: Option<String>,
}

/// The lines, and their labels.
#[derive(Clone, Debug, Default)]
pub(super) struct Program {
    pub(super) lines: Vec<Line>,
    /// `N` words: targets of GOTO.
    pub(super) labels: HashMap<u32, usize>,
}

impl Program {
    pub(super) fn new(text: &str, dialect: Dialect) -> Result<Self, (usize, String)> {
        if dialect == Dialect::Sinumerik {
            return Ok(Self::sinumerik(text));
        }
        let mut program = Self::default();
        for (i, raw) in text.lines().enumerate() {
            let line = strip(raw).map_err(|e| (i, e))?;
            if let Some(label) = leading(&line.text, 'N')
                && program.labels.insert(label, i).is_some()
            {
                return Err((i, format!("N{label} stands twice")));
            }
            program.lines.push(line);
        }
        Ok(program)
    }

    /// Lines in which `;` begins a comment; their labels are names.
    fn sinumerik(text: &str) -> Self {
        let stripped = |raw: &str| raw.split(';').next().unwrap_or_default().trim().to_ascii_uppercase();
        let lines = text.lines().map(|raw| Line { text: stripped(raw), abort: None }).collect();
        Self { lines, labels: HashMap::new() }
    }

    /// The line after `from` that satisfies `wanted` at the same depth of `o` words with the same
    /// label.
    pub(super) fn after(&self, from: usize, label: u32, wanted: &[&str]) -> Option<usize> {
        let is = |line: &Line| o_word(&line.text).is_some_and(|(l, rest)| l == label && starts(rest, wanted));
        (from + 1..self.lines.len()).find(|&i| is(&self.lines[i]))
    }

    /// The line before `from` that satisfies `wanted` with the same label.
    pub(super) fn before(&self, from: usize, label: u32, wanted: &[&str]) -> Option<usize> {
        let is = |line: &Line| o_word(&line.text).is_some_and(|(l, rest)| l == label && starts(rest, wanted));
        (0..from).rev().find(|&i| is(&self.lines[i]))
    }

    /// The line that begins with `text`, searched from `from` on or, backwards, before it.
    pub(super) fn line_with(&self, from: usize, text: &str, backwards: bool) -> Option<usize> {
        let is = |i: &usize| {
            let line = &self.lines[*i].text;
            if text.starts_with("DO") {
                line.starts_with("WHILE") && line.ends_with(text)
            } else {
                line == text
            }
        };
        if backwards { (0..from).rev().find(is) } else { (from + 1..self.lines.len()).find(is) }
    }
}

fn starts(rest: &str, wanted: &[&str]) -> bool {
    wanted.iter().any(|w| rest.starts_with(w))
}

/// Label and rest of LinuxCNC's `o101 if …`; `O8001` alone is a program number.
pub(super) fn o_word(text: &str) -> Option<(u32, &str)> {
    let label = leading(text, 'O')?;
    let rest = text[1..].trim_start_matches(|c: char| c.is_ascii_digit()).trim_start();
    (!rest.is_empty()).then_some((label, rest))
}

/// The whole number after a leading letter.
pub(super) fn leading(text: &str, letter: char) -> Option<u32> {
    let digits = text.strip_prefix(letter)?;
    let end = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
    digits[..end].parse().ok()
}

fn strip(raw: &str) -> Result<Line, String> {
    let mut line = Line::default();
    let mut rest = raw;
    while let Some(open) = rest.find('(') {
        line.text += &rest[..open];
        let Some(length) = rest[open..].find(')') else { return Err("a comment is not closed".into()) };
        let comment = &rest[open + 1..open + length];
        if comment.contains('(') {
            return Err("a comment holds a bracket".into());
        }
        if comment.to_ascii_uppercase().starts_with("ABORT,") {
            line.abort = Some(comment[6..].to_owned());
        }
        rest = &rest[open + length + 1..];
    }
    line.text = (line.text + rest).trim().to_ascii_uppercase();
    Ok(line)
}
