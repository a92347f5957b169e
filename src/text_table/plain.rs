//! Tables whose columns go by their order, with names above them or without.

use std::ops::RangeInclusive;

use super::dialect::{
    Comments, SEPARATORS, TextTableError, decoded, line_of, number, reader, separator_line,
};

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

#[cfg(test)]
mod tests {
    use super::*;

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
}
