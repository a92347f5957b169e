//! Self-contained HTML pages: no script, no font, no address outside the file.
//!
//! In: headings, texts, tables and pictures. Out: a page that is read on a wide screen and on one
//! of 390 px (tables and charts scroll in boxes of their own), light or dark, on A4 paper, and
//! aloud.

use std::fmt::Write as _;

use super::colours;

/// A page under construction.
#[derive(Clone, Debug, Default)]
pub(crate) struct Page {
    title: String,
    body: String,
    /// The last heading: what a table or a figure belongs to.
    section: String,
}

/// Everything but the colours.
const STYLE: &str = "*{box-sizing:border-box}\
body{font:16px/1.5 system-ui,sans-serif;max-width:960px;margin:2em auto;padding:0 1em;background:var(--paper);color:var(--ink);overflow-wrap:break-word}\
h1{font-size:1.5em;line-height:1.25;margin-bottom:.2em}h2{font-size:1.15em;margin:1.8em 0 .4em;border-bottom:1px solid var(--rule)}\
.scroll{overflow-x:auto;margin:.6em 0}.scroll:focus-visible,summary:focus-visible{outline:2px solid var(--c0);outline-offset:2px}\
table{border-collapse:collapse;font-variant-numeric:tabular-nums}th,td{padding:.25em .8em;text-align:left;vertical-align:top;border-bottom:1px solid var(--rule)}\
thead th{font-weight:600;background:var(--shade);vertical-align:bottom}tbody th{font-weight:400}th.n,td.n{text-align:right}td.n,tbody th{white-space:nowrap}\
td.long{min-width:16em;font-size:.92em}tbody th.long{white-space:normal;min-width:13em}\
figure{margin:1em 0}figcaption,.note{color:var(--muted);font-size:.92em}svg,img{max-width:100%;height:auto}summary{cursor:pointer}\
.verdict{font-weight:600;border-left:.4em solid;padding:.2em .8em}.good{color:var(--good)}.open{color:var(--open)}.bad{color:var(--bad)}\
@media(max-width:600px){body{margin-top:1em}figure .scroll .chart{width:660px;max-width:none}th,td{padding:.25em .4em}tbody th.long{min-width:12em;font-size:.9em}}\
@page{size:A4;margin:15mm}\
@media print{body{font-size:10pt;max-width:none;margin:0;padding:0}.scroll{overflow:visible}th,td{padding:.15em .4em}table{font-size:8.5pt}\
td.long,tbody th.long{min-width:0}td.n,tbody th{white-space:normal}thead{display:table-header-group}tr,figure,.verdict{break-inside:avoid}h1,h2{break-after:avoid}\
details::details-content{content-visibility:visible;height:auto}}";

/// Number of characters above which a cell is a sentence.
const SENTENCE: usize = 32;

/// How a verdict is: its colour is never all that shows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tone {
    /// Proven good.
    Good,
    /// Neither proven good nor bad, or not judged.
    Open,
    /// Proven bad.
    Bad,
}

impl Tone {
    /// The class of its colour, and a sign before the words.
    fn look(self) -> (&'static str, &'static str) {
        match self {
            Self::Good => ("good", "\u{2713}"),
            Self::Open => ("open", "?"),
            Self::Bad => ("bad", "\u{2717}"),
        }
    }
}

/// Whether a cell is a number, with its sign, unit sign or interval.
fn is_number(cell: &str) -> bool {
    let figures = |c: char| c.is_ascii_digit() || ".,+-\u{2212}\u{b1}%\u{b0}\u{d7} eE".contains(c);
    cell.chars().any(|c| c.is_ascii_digit()) && cell.chars().all(figures)
}

/// Whether a column is of numbers: at least one, and what is none is empty or a dash.
fn is_of_numbers(rows: &[Vec<String>], column: usize) -> bool {
    let cells = || rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.trim());
    let is_empty = |cell: &str| matches!(cell, "" | "-" | "\u{2013}");
    cells().any(is_number) && cells().all(|cell| is_number(cell) || is_empty(cell))
}

impl Page {
    /// An empty page.
    pub(crate) fn new(title: impl Into<String>) -> Self {
        let title = title.into();
        let body = format!("<h1>{}</h1>\n", escape(&title));
        Self { section: title.clone(), title, body }
    }

    /// A section's heading.
    pub(crate) fn heading(&mut self, text: &str) -> &mut Self {
        let _ = writeln!(self.body, "<h2>{}</h2>", escape(text));
        text.clone_into(&mut self.section);
        self
    }

    /// A paragraph of plain text.
    pub(crate) fn text(&mut self, text: &str) -> &mut Self {
        let _ = writeln!(self.body, "<p>{}</p>", escape(text));
        self
    }

    /// A verdict in plain text.
    pub(crate) fn verdict(&mut self, tone: Tone, text: &str) -> &mut Self {
        let (class, sign) = tone.look();
        let sign = format!("<span aria-hidden=\"true\">{sign}</span>");
        let _ = writeln!(self.body, "<p class=\"verdict {class}\">{sign} {}</p>", escape(text));
        self
    }

    /// A box that scrolls by itself where it is wider than the page; it can be reached by keys.
    fn boxed(&mut self, what: &str, inside: &str) {
        let name = escape(&format!("{}: {what}", self.section));
        let _ = writeln!(
            self.body,
            "<div class=\"scroll\" tabindex=\"0\" role=\"group\" aria-label=\"{name}\">{inside}</div>"
        );
    }

    /// A table; cells are plain text, the first of a row names it. Columns of numbers are aligned
    /// right.
    pub(crate) fn table(&mut self, header: &[&str], rows: &[Vec<String>]) -> &mut Self {
        let numbers: Vec<bool> = (0..header.len()).map(|column| is_of_numbers(rows, column)).collect();
        let class = |column: usize, cell: &str| {
            if numbers.get(column).copied().unwrap_or(false) {
                " class=\"n\""
            } else if cell.chars().count() > SENTENCE {
                " class=\"long\""
            } else {
                ""
            }
        };
        let mut table = String::from("<table><thead><tr>");
        for (column, cell) in header.iter().enumerate() {
            let _ = write!(table, "<th scope=\"col\"{}>{}</th>", class(column, ""), escape(cell));
        }
        table.push_str("</tr></thead>\n<tbody>\n");
        for row in rows {
            table.push_str("<tr>");
            for (column, cell) in row.iter().enumerate() {
                let class = class(column, cell);
                let _ = match column {
                    0 => write!(table, "<th scope=\"row\"{class}>{}</th>", escape(cell)),
                    _ => write!(table, "<td{class}>{}</td>", escape(cell)),
                };
            }
            table.push_str("</tr>\n");
        }
        table.push_str("</tbody></table>");
        self.boxed("table", &table);
        self
    }

    /// As [`Self::table`], without the columns that are empty in every row.
    pub(crate) fn filled_columns(&mut self, header: &[&str], rows: &[Vec<String>]) -> &mut Self {
        let is_filled = |column: usize| {
            rows.is_empty() || rows.iter().any(|row| row.get(column).is_some_and(|cell| !cell.is_empty()))
        };
        let kept: Vec<usize> = (0..header.len()).filter(|column| is_filled(*column)).collect();
        let header: Vec<&str> = kept.iter().map(|column| header[*column]).collect();
        let cells = |row: &Vec<String>| kept.iter().filter_map(|column| row.get(*column).cloned()).collect();
        self.table(&header, &rows.iter().map(cells).collect::<Vec<_>>())
    }

    /// A figure: SVG that names itself (`role="img"`, `aria-label`), with a caption in plain text.
    pub(crate) fn figure(&mut self, svg: &str, caption: &str) -> &mut Self {
        self.body.push_str("<figure>");
        self.boxed("figure", svg);
        let _ = writeln!(self.body, "<figcaption>{}</figcaption></figure>", escape(caption));
        self
    }

    /// A PNG picture, what it shows in words, and a caption in plain text.
    pub(crate) fn image(&mut self, png: &[u8], shows: &str, caption: &str) -> &mut Self {
        let _ = writeln!(
            self.body,
            "<figure><img src=\"data:image/png;base64,{}\" alt=\"{}\"><figcaption>{}</figcaption></figure>",
            base64(png),
            escape(shows),
            escape(caption)
        );
        self
    }

    /// The content added by `inside`, folded under a line of plain text until the reader opens it.
    ///
    /// # Errors
    /// Those of `inside`.
    pub(crate) fn folded<E>(
        &mut self,
        line: &str,
        inside: impl FnOnce(&mut Self) -> Result<(), E>,
    ) -> Result<(), E> {
        let _ = writeln!(self.body, "<details><summary>{}</summary>", escape(line));
        let result = inside(self);
        self.body.push_str("</details>\n");
        result
    }

    /// The page's text.
    pub(crate) fn finish(&self) -> String {
        format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><meta name=\"color-scheme\" content=\"light dark\">\
             <title>{}</title><style>{}{STYLE}</style></head>\n<body>\n<main>\n{}</main>\n</body></html>\n",
            escape(&self.title),
            colours::style(),
            self.body
        )
    }
}

/// Text made safe for HTML.
pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Bytes as base64 (RFC 4648), for `data:` addresses.
pub(crate) fn base64(bytes: &[u8]) -> String {
    const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let word = chunk.iter().fold(0u32, |w, &b| (w << 8) | u32::from(b)) << (8 * (3 - chunk.len()));
        for i in 0..4 {
            let symbol = ALPHABET[(word >> (18 - 6 * i)) as usize & 63];
            text.push(if i <= chunk.len() { char::from(symbol) } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_the_rfc() {
        let cases = [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")];
        for (plain, coded) in cases {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }

    #[test]
    fn text_cannot_break_out() {
        let mut page = Page::new("a<b");
        page.text("<script>").table(&["x&y"], &[vec!["\"".to_owned()]]);
        let html = page.finish();
        assert!(!html.contains("<script>") && html.contains("a&lt;b") && html.contains("x&amp;y"));
        page.heading("\"onload=x").figure("<svg></svg>", "c").image(&[], "\"x", "");
        let html = page.finish();
        assert!(
            html.contains("aria-label=\"&quot;onload=x: figure\"") && html.contains("alt=\"&quot;x\""),
            "{html}"
        );
    }

    #[test]
    fn columns_of_numbers_are_aligned_right_and_the_first_cell_names_its_row() {
        let row = |cells: [&str; 4]| cells.map(str::to_owned).to_vec();
        let mut page = Page::new("t");
        page.table(
            &["name", "d / mm", "note", "U"],
            &[row(["a", "24.98", "GO 1", "\u{b1} 0.2"]), row(["b", "\u{2013}", "", "-"])],
        );
        let html = page.finish();
        for part in [
            "<th scope=\"col\">name</th><th scope=\"col\" class=\"n\">d / mm</th><th scope=\"col\">note</th><th scope=\"col\" class=\"n\">U</th>",
            "<th scope=\"row\">a</th><td class=\"n\">24.98</td><td>GO 1</td><td class=\"n\">\u{b1} 0.2</td>",
            "<th scope=\"row\">b</th><td class=\"n\">\u{2013}</td>",
        ] {
            assert!(html.contains(part), "{part} is not in {html}");
        }
    }

    #[test]
    fn empty_columns_are_left_out() {
        let rows = [["1", "", "x"], ["2", "", ""]].map(|row| row.map(str::to_owned).to_vec());
        let html = Page::new("t").filled_columns(&["a", "b", "c"], &rows).finish();
        assert!(
            !html.contains(">b</th>") && html.contains(">c</th>") && html.contains("<td>x</td>"),
            "{html}"
        );
    }

    #[test]
    fn a_page_serves_small_dark_and_paper() {
        let html = Page::new("t").verdict(Tone::Bad, "out of tolerance").finish();
        for part in [
            "name=\"viewport\"",
            "lang=\"en\"",
            "max-width:600px",
            "prefers-color-scheme:dark",
            "@media print",
            "size:A4",
            "<main>",
            "<p class=\"verdict bad\"><span aria-hidden=\"true\">\u{2717}</span> out of tolerance</p>",
        ] {
            assert!(html.contains(part), "{part} is not in {html}");
        }
        assert!(!html.contains("<script") && !html.contains("http"), "nothing from outside: {html}");
    }
}
