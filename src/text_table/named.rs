//! Tables with names in their first row.

use csv::StringRecord;

use super::dialect::{
    Comments, SEPARATORS, TextTableError, decoded, line_of, number, reader, separator_line,
};

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

    #[test]
    fn a_hash_is_a_comment_only_where_a_table_has_them() {
        let text = b"frame,z_mm\n#1,2\n";
        let rows = |comments| TextTable::parse(text, &["frame"], comments).unwrap().rows().count();
        assert_eq!((rows(Comments::None), rows(Comments::Hash)), (1, 0));
    }
}
