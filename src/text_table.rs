//! Tables of text with names in their first row, as programs and spreadsheets write them.
//!
//! Separated by commas, semicolons or tabs; decimal points, or decimal commas where they do not
//! separate; any line ending; UTF-8 with or without a byte order mark, UTF-16 with one, or Latin-1;
//! quoted fields; Excel's `sep=` line; lines that begin with `#` where a table has comments. What
//! a column means, and which of them a table must have, is its reader's affair.

use std::ops::RangeInclusive;

use csv::StringRecord;

/// Separators looked for, in this order.
const SEPARATORS: [u8; 3] = *b",;\t";

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

/// A table: names of columns, and rows that are not empty.
#[derive(Clone, Debug)]
pub(crate) struct TextTable {
    names: Vec<String>,
    /// Row of the names, as a spreadsheet counts.
    head: usize,
    separator: u8,
    rows: Vec<TextRow>,
}

/// A row below the names.
#[derive(Clone, Debug)]
struct TextRow {
    row: usize,
    line: u64,
    fields: StringRecord,
}

/// A row with the names of its columns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cells<'a> {
    names: &'a [String],
    own: &'a TextRow,
}

impl TextTable {
    /// Reads a table; `expected` are columns that tables of its kind have: that separator is taken
    /// under which most of them stand.
    ///
    /// # Errors
    /// UTF-16 that ends within a letter.
    pub(crate) fn parse(bytes: &[u8], expected: &[&str], comments: Comments) -> Result<Self, TextTableError> {
        let text = decoded(bytes).map_err(|what| TextTableError { row: None, line: None, what })?;
        let (text, stated) = separator_line(&text);
        let above = usize::from(stated.is_some());
        let candidates = stated.map_or(SEPARATORS.to_vec(), |s| vec![s]);
        let headers = candidates.into_iter().map(|s| (s, names(text, s, comments)));
        let stands = |name: &&&str, names: &[String]| names.iter().any(|found| found == **name);
        let fit = |names: &[String]| (expected.iter().filter(|e| stands(e, names)).count(), names.len());
        let best = headers.max_by_key(|(_, names)| fit(names));
        let (separator, names) = best.unwrap_or((b',', Vec::new()));
        let mut table = Self { names, head: 1 + above, separator, rows: Vec::new() };
        for (index, record) in reader(text, separator, comments).records().enumerate().skip(1) {
            let fields = record.map_err(|e| TextTableError {
                row: Some(index + 1 + above),
                line: None,
                what: e.to_string(),
            })?;
            if fields.iter().all(str::is_empty) {
                continue;
            }
            let line = line_of(text, fields.position(), comments) + above as u64;
            table.rows.push(TextRow { row: index + 1 + above, line, fields });
        }
        Ok(table)
    }

    /// Names of the columns, in small letters.
    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    /// Row of the names, as a spreadsheet counts: 2 below a `sep=` line.
    pub(crate) fn head(&self) -> usize {
        self.head
    }

    /// Whether it has a column.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.names.iter().any(|found| found == name)
    }

    /// The first of some names that two columns have.
    pub(crate) fn twice<'a>(&self, of: &[&'a str]) -> Option<&'a str> {
        of.iter().copied().find(|name| self.names.iter().filter(|found| *found == name).count() > 1)
    }

    /// The rows; each refused that has fewer fields than there are names, or more.
    pub(crate) fn rows(&self) -> impl Iterator<Item = Result<Cells<'_>, TextTableError>> {
        self.rows.iter().map(|own| {
            check_length(own, self.names.len(), self.separator)?;
            Ok(Cells { names: &self.names, own })
        })
    }

    /// Refuses a table in which one of these columns is missing, or stands twice.
    ///
    /// # Errors
    /// The column, with the header that the table should have.
    pub(crate) fn require(&self, columns: &[&str]) -> Result<(), String> {
        if let Some(missing) = columns.iter().find(|name| !self.has(name)) {
            return Err(format!(
                "has no column {missing}, only '{}'; its header must be {}",
                self.names.join(","),
                columns.join(",")
            ));
        }
        self.twice(columns).map_or(Ok(()), |name| Err(format!("has two columns {name}")))
    }
}

impl<'a> Cells<'a> {
    /// The row as a spreadsheet counts.
    pub(crate) fn row(&self) -> usize {
        self.own.row
    }

    /// The line as an editor counts.
    pub(crate) fn line(&self) -> u64 {
        self.own.line
    }

    /// A cell; none where the table has no such column.
    pub(crate) fn text(&self, name: &str) -> Option<&'a str> {
        let index = self.names.iter().position(|found| found == name)?;
        self.own.fields.get(index)
    }

    /// A cell that must hold a finite number.
    ///
    /// # Errors
    /// The line, the column and what stands there.
    pub(crate) fn number(&self, name: &str) -> Result<f64, String> {
        let found = self.text(name).unwrap_or_default();
        let wrong = || format!("line {}: {name} '{found}' must be a finite number", self.line());
        number(found).ok_or_else(wrong)
    }
}

/// A row of a table that needs no names: its columns go by their order.
#[derive(Clone, Debug)]
pub(crate) struct PlainRow {
    /// The line as an editor counts.
    pub line: u64,
    /// Its fields, without empty ones at the end.
    pub fields: Vec<String>,
    separator: u8,
}

impl PlainRow {
    /// Its numbers; none where one of its fields is no finite number.
    pub(crate) fn numbers(&self) -> Option<Vec<f64>> {
        self.fields.iter().map(|field| number(field)).collect()
    }

    /// Whether it holds names: its fields begin with letters.
    pub(crate) fn is_header(&self) -> bool {
        self.fields.iter().all(|field| field.starts_with(char::is_alphabetic))
    }

    /// The fields with their separator.
    pub(crate) fn shown(&self) -> String {
        self.fields.join(&char::from(self.separator).to_string())
    }
}

/// Reads a table that may stand without names, with lines of comments; `columns` are how many
/// numbers a row may have: that separator is taken under which most rows have as many.
///
/// # Errors
/// UTF-16 that ends within a letter.
pub(crate) fn plain_rows(
    bytes: &[u8],
    columns: &RangeInclusive<usize>,
) -> Result<Vec<PlainRow>, TextTableError> {
    let text = decoded(bytes).map_err(|what| TextTableError { row: None, line: None, what })?;
    let (text, stated) = separator_line(&text);
    let above = u64::from(stated.is_some());
    let rows = |separator: u8| -> Result<Vec<PlainRow>, TextTableError> {
        let records = reader(text, separator, Comments::Hash).into_records();
        let rows = records.map(|record| {
            let record = record.map_err(|e| TextTableError { row: None, line: None, what: e.to_string() })?;
            let mut fields: Vec<String> = record.iter().map(str::to_owned).collect();
            while fields.last().is_some_and(String::is_empty) {
                fields.pop();
            }
            let line = line_of(text, record.position(), Comments::Hash) + above;
            Ok(PlainRow { line, fields, separator })
        });
        let is_filled = |row: &Result<PlainRow, _>| row.as_ref().map_or(true, |row| !row.fields.is_empty());
        rows.filter(is_filled).collect()
    };
    let fit = |rows: &Vec<PlainRow>| {
        let fits = |row: &&PlainRow| row.numbers().is_some_and(|n| columns.contains(&n.len()));
        rows.iter().filter(fits).count()
    };
    let candidates = stated.map_or(SEPARATORS.to_vec(), |s| vec![s]);
    let mut best: Option<Vec<PlainRow>> = None;
    for separator in candidates {
        let found = rows(separator)?;
        if best.as_ref().is_none_or(|best| fit(&found) > fit(best)) {
            best = Some(found);
        }
    }
    Ok(best.unwrap_or_default())
}

/// A finite number with a decimal point or a decimal comma.
pub(crate) fn number(text: &str) -> Option<f64> {
    let point = if text.contains('.') { text.to_owned() } else { text.replacen(',', ".", 1) };
    point.parse::<f64>().ok().filter(|v| v.is_finite())
}

/// The text of a file: UTF-8, UTF-16 with its mark, or Latin-1 (whose letters no column needs).
fn decoded(bytes: &[u8]) -> Result<String, String> {
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
fn separator_line(text: &str) -> (&str, Option<u8>) {
    let Some(rest) = text.strip_prefix("sep=") else { return (text, None) };
    let Some(separator) = rest.bytes().next().filter(u8::is_ascii) else { return (text, None) };
    (rest[1..].trim_start_matches(['\r', '\n']), Some(separator))
}

fn reader(text: &str, separator: u8, comments: Comments) -> csv::Reader<&[u8]> {
    let mut builder = csv::ReaderBuilder::new();
    builder.delimiter(separator).has_headers(false).flexible(true).trim(csv::Trim::All);
    builder.comment((comments == Comments::Hash).then_some(b'#')).from_reader(text.as_bytes())
}

/// The line of a record, from 1: the reader's place is before empty lines and comments above it.
fn line_of(text: &str, place: Option<&csv::Position>, comments: Comments) -> u64 {
    let Some(place) = place else { return 0 };
    let from = text.get(place.byte() as usize..).unwrap_or_default();
    let is_skipped = |line: &&str| {
        line.trim_end_matches('\r').is_empty() || (comments == Comments::Hash && line.starts_with('#'))
    };
    place.line() + from.split('\n').take_while(is_skipped).count() as u64
}

fn names(text: &str, separator: u8, comments: Comments) -> Vec<String> {
    let first = reader(text, separator, comments).records().next().and_then(Result::ok);
    first.map_or_else(Vec::new, |r| r.iter().map(str::to_ascii_lowercase).collect())
}

/// At least as many fields as names; additional ones must be empty.
fn check_length(own: &TextRow, right: usize, separator: u8) -> Result<(), TextTableError> {
    let found = own.fields.len();
    if found >= right && own.fields.iter().skip(right).all(str::is_empty) {
        return Ok(());
    }
    let comma = if separator == b',' { " (a decimal comma between commas must stand in quotes)" } else { "" };
    let what = format!("{found} fields under {right} names{comma}");
    Err(TextTableError { row: Some(own.row), line: Some(own.line), what })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &[u8]) -> Result<TextTable, String> {
        TextTable::parse(text, &["z_mm", "value"], Comments::Hash).map_err(|e| e.to_string())
    }

    /// The same two rows in every dialect.
    #[test]
    fn every_dialect_has_the_same_cells() {
        let points = "# read by hand\nz_mm,name,value\n-1.25,b,3.5\n2,c,0\n";
        let commas = "# read by hand\nz_mm;name;value\n-1,25;b;3,5\n2;c;0\n";
        let mut wide = vec![0xfe, 0xff];
        wide.extend(commas.replace(';', "\t").encode_utf16().flat_map(u16::to_be_bytes));
        for bytes in [
            points.as_bytes().to_vec(),
            points.replace('\n', "\r\n").into_bytes(),
            points.replace("-1.25", "\"-1,25\"").into_bytes(),
            points.replace("z_mm", "Z_MM").replace("0\n", "0\n,,\n").into_bytes(),
            [b"\xef\xbb\xbf".as_slice(), commas.as_bytes()].concat(),
            format!("sep=;\r\n{commas}").into_bytes(),
            commas.replace(";0\n", ";0;;\n").into_bytes(),
            wide,
        ] {
            let shown = String::from_utf8_lossy(&bytes).into_owned();
            let table = parsed(&bytes).unwrap_or_else(|e| panic!("{e}: {shown:?}"));
            let cells: Vec<(f64, Option<&str>, f64)> = table
                .rows()
                .map(Result::unwrap)
                .map(|row| (row.number("z_mm").unwrap(), row.text("name"), row.number("value").unwrap()))
                .collect();
            assert_eq!(cells, [(-1.25, Some("b"), 3.5), (2.0, Some("c"), 0.0)], "{shown:?}");
            assert!(table.has("name") && !table.has("none") && table.require(&["value"]).is_ok());
        }
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        let cell = |text: &str| -> Result<(), String> {
            let table = parsed(text.as_bytes())?;
            table.require(&["z_mm", "value"])?;
            table.rows().try_for_each(|row| row.map_err(|e| e.to_string())?.number("value").map(drop))
        };
        for (text, words) in [
            ("z_mm,value\n1,2\n1,far\n", "line 3: value 'far' must be a finite number"),
            ("# a\nz_mm,value\n1,\n", "line 3: value '' must"),
            ("z_mm,value\n1,inf\n", "line 2: value 'inf'"),
            ("z_mm;value\n1;1.000,5\n", "line 2: value '1.000,5'"),
            ("z_mm,value\n1,2,5\n", "line 2: 3 fields under 2 names (a decimal comma"),
            ("z_mm;value\n1\n", "line 2: 1 fields under 2 names"),
            ("sep=;\nz_mm;value\n1;x\n", "line 3: value 'x'"),
            ("z_mm,values\n1,2\n", "no column value, only 'z_mm,values'; its header must be z_mm,value"),
            ("z_mm,value,value\n1,2,3\n", "two columns value"),
            ("", "no column z_mm"),
        ] {
            let refused = cell(text).unwrap_err();
            assert!(refused.contains(words), "{text:?}: {refused}");
        }
    }

    /// Pairs of a table without names, in every dialect; `sep=` and comments count as lines.
    #[test]
    fn columns_that_go_by_their_order_are_read_in_every_dialect() {
        let points = "# a\n-1.5,2\n0.25,3,,\n\n4,5.5\n";
        let commas = "# a\n-1,5;2\n0,25;3;;\n\n4;5,5\n";
        let mut wide = vec![0xff, 0xfe];
        wide.extend(commas.encode_utf16().flat_map(u16::to_le_bytes));
        for (bytes, above) in [
            (points.as_bytes().to_vec(), 0),
            (commas.as_bytes().to_vec(), 0),
            (commas.replace(';', "\t").replace('\n', "\r\n").into_bytes(), 0),
            ([b"\xef\xbb\xbf".as_slice(), commas.as_bytes()].concat(), 0),
            (format!("sep=;\n{commas}").into_bytes(), 1),
            (wide, 0),
        ] {
            let shown = String::from_utf8_lossy(&bytes).into_owned();
            let rows = plain_rows(&bytes, &(2..=2)).unwrap();
            let numbers: Vec<Vec<f64>> = rows.iter().filter_map(PlainRow::numbers).collect();
            assert_eq!(numbers, [[-1.5, 2.0], [0.25, 3.0], [4.0, 5.5]], "{shown:?}");
            let lines: Vec<u64> = rows.iter().map(|row| row.line - above).collect();
            assert_eq!(lines, [2, 3, 5], "{shown:?}");
        }
        let named = plain_rows(b"d_um;intensity\n0,5;1,5\n1;x\n", &(2..=2)).unwrap();
        assert!(named[0].is_header() && !named[1].is_header() && named[2].numbers().is_none());
        assert_eq!(named[2].shown(), "1;x");
    }

    #[test]
    fn a_hash_is_a_comment_only_where_a_table_has_them() {
        let text = b"frame,z_mm\n#1,2\n";
        let rows = |comments| TextTable::parse(text, &["frame"], comments).unwrap().rows().count();
        assert_eq!((rows(Comments::None), rows(Comments::Hash)), (1, 0));
    }
}
