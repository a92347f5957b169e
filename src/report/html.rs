//! Self-contained HTML pages: no script, no font, no address outside the file.

use std::fmt::Write as _;

/// A page under construction.
#[derive(Clone, Debug, Default)]
pub(crate) struct Page {
    title: String,
    body: String,
}

const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;max-width:900px;margin:2em auto;padding:0 1em;color:#222}\
h1{font-size:1.5em;margin-bottom:.2em}h2{font-size:1.15em;margin:1.8em 0 .4em;border-bottom:1px solid #ddd}\
table{border-collapse:collapse;margin:.6em 0}th,td{padding:.25em .8em;text-align:right;border-bottom:1px solid #e4e4e4}\
th{font-weight:600;background:#f6f6f6}td:first-child,th:first-child,td.s{text-align:left}td.s{font-size:.92em}figure{margin:1em 0}\
figcaption,.note{color:#555;font-size:.92em}svg,img{max-width:100%;height:auto}.good{color:#00724f}.bad{color:#b33c00}code{background:#f3f3f3}\
@media(max-width:600px){figure{overflow-x:auto}figure svg{min-width:620px;max-width:none}table{display:block;overflow-x:auto}\
th,td{padding:.25em .4em}}\
@media(prefers-color-scheme:dark){:root{color-scheme:dark}body{background:#17191c;color:#dcdcdc}figure svg{background:#fff}\
h2{border-color:#444}th,td{border-color:#3a3d41}th,code{background:#26292e}figcaption,.note{color:#a9adb3}.good{color:#3ecf9b}.bad{color:#ff9a6b}}";

/// Number of characters above which a cell is a sentence and is aligned left.
const SENTENCE: usize = 32;

impl Page {
    /// An empty page.
    pub(crate) fn new(title: impl Into<String>) -> Self {
        let title = title.into();
        let body = format!("<h1>{}</h1>\n", escape(&title));
        Self { title, body }
    }

    /// A section's heading.
    pub(crate) fn heading(&mut self, text: &str) -> &mut Self {
        let _ = writeln!(self.body, "<h2>{}</h2>", escape(text));
        self
    }

    /// A paragraph of plain text.
    pub(crate) fn text(&mut self, text: &str) -> &mut Self {
        let _ = writeln!(self.body, "<p>{}</p>", escape(text));
        self
    }

    /// A table; cells are plain text.
    pub(crate) fn table(&mut self, header: &[&str], rows: &[Vec<String>]) -> &mut Self {
        self.body.push_str("<table><tr>");
        for cell in header {
            let _ = write!(self.body, "<th>{}</th>", escape(cell));
        }
        self.body.push_str("</tr>\n");
        for row in rows {
            self.body.push_str("<tr>");
            for cell in row {
                let class = if cell.chars().count() > SENTENCE { " class=\"s\"" } else { "" };
                let _ = write!(self.body, "<td{class}>{}</td>", escape(cell));
            }
            self.body.push_str("</tr>\n");
        }
        self.body.push_str("</table>\n");
        self
    }

    /// A figure: SVG or `<img>` markup, with a caption in plain text.
    pub(crate) fn figure(&mut self, markup: &str, caption: &str) -> &mut Self {
        let _ = writeln!(self.body, "<figure>{markup}<figcaption>{}</figcaption></figure>", escape(caption));
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
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{}</title><style>{STYLE}</style></head>\n<body>\n{}</body></html>\n",
            escape(&self.title),
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
    }
}
