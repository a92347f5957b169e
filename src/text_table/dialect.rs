//! What programs and spreadsheets differ in: encoding, separator, decimal comma, comments.

/// Separators looked for, in this order.
pub(super) const SEPARATORS: [u8; 3] = *b",;\t";

/// Whether lines that begin with `#` are comments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Comments {
    /// They are rows: the first column may begin so.
    None,
    /// They are passed over.
    Hash,
}

/// Why a text is no table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TextTableError {
    /// The row as a spreadsheet counts, the header 1, where one is wrong.
    pub row: Option<usize>,
    /// The line as an editor counts, where one is wrong.
    pub line: Option<u64>,
    /// What was found, and what would be right.
    pub what: String,
}

impl std::fmt::Display for TextTableError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.line {
            Some(line) => write!(f, "line {line}: {}", self.what),
            None => f.write_str(&self.what),
        }
    }
}

/// The text of a file: UTF-8, UTF-16 with its mark, or Latin-1 (whose letters no column needs).
pub(super) fn decoded(bytes: &[u8]) -> Result<String, String> {
    let wide = |pair: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes[2..].chunks_exact(2).map(|b| pair([b[0], b[1]])).collect();
        String::from_utf16(&units).map_err(|_| "UTF-16 that ends within a letter".to_owned())
    };
    match bytes {
        [0xff, 0xfe, ..] => wide(u16::from_le_bytes),
        [0xfe, 0xff, ..] => wide(u16::from_be_bytes),
        _ => {
            let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
            let latin = |_| bytes.iter().map(|b| char::from(*b)).collect();
            Ok(std::str::from_utf8(bytes).map_or_else(latin, str::to_owned))
        }
    }
}

/// Removes Excel's first line `sep=;`.
pub(super) fn separator_line(text: &str) -> (&str, Option<u8>) {
    let Some(rest) = text.strip_prefix("sep=") else { return (text, None) };
    let Some(separator) = rest.bytes().next().filter(u8::is_ascii) else { return (text, None) };
    (rest[1..].trim_start_matches(['\r', '\n']), Some(separator))
}

pub(super) fn reader(text: &str, separator: u8, comments: Comments) -> csv::Reader<&[u8]> {
    let mut builder = csv::ReaderBuilder::new();
    builder.delimiter(separator).has_headers(false).flexible(true).trim(csv::Trim::All);
    builder.comment((comments == Comments::Hash).then_some(b'#')).from_reader(text.as_bytes())
}

/// The line of a record, from 1: the reader's place is before empty lines and comments above it.
pub(super) fn line_of(text: &str, place: Option<&csv::Position>, comments: Comments) -> u64 {
    let Some(place) = place else { return 0 };
    let from = text.get(place.byte() as usize..).unwrap_or_default();
    let is_skipped = |line: &&str| {
        line.trim_end_matches('\r').is_empty() || (comments == Comments::Hash && line.starts_with('#'))
    };
    place.line() + from.split('\n').take_while(is_skipped).count() as u64
}

/// A finite number with a decimal point or a decimal comma.
pub(crate) fn number(text: &str) -> Option<f64> {
    let point = if text.contains('.') { text.to_owned() } else { text.replacen(',', ".", 1) };
    point.parse::<f64>().ok().filter(|v| v.is_finite())
}
