//! The wear history of an edge: a table in CSV, a reading a row.

use serde::Deserialize as _;
use serde::de::IntoDeserializer as _;
use serde::de::value::{Error as ValueError, StrDeserializer};

use super::blunt::WearVerdict;
use crate::text_table::{Cells, Comments, TextTable};
use crate::tool::error::ToolError;

/// Columns of a history.
const COLUMNS: [&str; 7] = ["cut", "image", "vbb_um", "u_vbb_um", "vbb_max_um", "u_vbb_max_um", "verdict"];

/// A reading.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct WearRow {
    /// Number of the cut after which it was taken, or another measure of use (minutes, metres).
    pub cut: f64,
    /// The image.
    pub image: String,
    /// Mean width over zone B, µm.
    pub vbb_um: f64,
    /// Its standard uncertainty, µm.
    pub u_vbb_um: f64,
    /// Largest width in zone B, µm.
    pub vbb_max_um: f64,
    /// Its standard uncertainty, µm.
    pub u_vbb_max_um: f64,
    /// The verdict.
    pub verdict: WearVerdict,
}

/// Reads a history; columns are found by name, separators and decimal commas as
/// [`crate::text_table`].
///
/// # Errors
/// A header without a column that is needed, a row that is no reading, or not after the row before
/// it: with its line.
pub(crate) fn read_history(bytes: impl AsRef<[u8]>) -> Result<Vec<WearRow>, ToolError> {
    let refuse = |line: u64, what: String| ToolError::History { line: line as usize, what };
    let table = TextTable::parse(bytes.as_ref(), &COLUMNS, Comments::None)
        .map_err(|e| refuse(e.line.unwrap_or(1), e.what))?;
    if table.names().is_empty() {
        return Ok(Vec::new());
    }
    table.require(&COLUMNS).map_err(|what| refuse(table.head() as u64, what))?;
    let mut rows: Vec<WearRow> = Vec::new();
    for cells in table.rows() {
        let cells = cells.map_err(|e| refuse(e.line.unwrap_or(0), e.what))?;
        let line = cells.line() as usize;
        let row = row(&cells).map_err(|what| ToolError::History { line, what })?;
        let numbers = [row.cut, row.vbb_um, row.u_vbb_um, row.vbb_max_um, row.u_vbb_max_um];
        if !numbers.iter().all(|v| v.is_finite() && *v >= 0.0) {
            let what = "cut, widths and their uncertainties are numbers from 0 up".to_owned();
            return Err(ToolError::History { line, what });
        }
        if let Some(before) = rows.last().filter(|before| row.cut < before.cut) {
            let what =
                format!("cut {} follows cut {}: rows stand in the order of the cuts", row.cut, before.cut);
            return Err(ToolError::History { line, what });
        }
        rows.push(row);
    }
    Ok(rows)
}

fn row(cells: &Cells<'_>) -> Result<WearRow, String> {
    let number = |name: &str| {
        let found = cells.text(name).unwrap_or_default();
        crate::text_table::number(found).ok_or_else(|| format!("{name} '{found}' must be a finite number"))
    };
    let word = cells.text("verdict").unwrap_or_default();
    let verdict: StrDeserializer<'_, ValueError> = word.into_deserializer();
    Ok(WearRow {
        cut: number("cut")?,
        image: cells.text("image").unwrap_or_default().to_owned(),
        vbb_um: number("vbb_um")?,
        u_vbb_um: number("u_vbb_um")?,
        vbb_max_um: number("vbb_max_um")?,
        u_vbb_max_um: number("u_vbb_max_um")?,
        verdict: WearVerdict::deserialize(verdict).map_err(|e| format!("verdict: {e}"))?,
    })
}

/// The text of a history.
///
/// # Errors
/// Where the writer fails, as text.
pub(crate) fn write_history(rows: &[WearRow]) -> Result<Vec<u8>, String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row).map_err(|e| e.to_string())?;
    }
    writer.into_inner().map_err(|e| e.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "cut,image,vbb_um,u_vbb_um,vbb_max_um,u_vbb_max_um,verdict\n\
        10.0,a,50.0,4.0,80.0,6.0,sharp\n20.0,b,70.5,4.0,120.0,6.0,doubtful\n";

    #[test]
    fn a_history_is_read_as_it_was_written() {
        let rows = read_history(TEXT).unwrap();
        assert_eq!((rows.len(), rows[1].vbb_um, rows[1].verdict), (2, 70.5, WearVerdict::Doubtful));
        assert_eq!(String::from_utf8(write_history(&rows).unwrap()).unwrap(), TEXT);
        assert_eq!(read_history("").unwrap(), []);
        // columns are found by name, and others are left alone
        let turned =
            "image,note,verdict,cut,vbb_um,u_vbb_um,vbb_max_um,u_vbb_max_um\na,new,sharp,1,2,3,4,5\n";
        assert_eq!(read_history(turned).unwrap()[0].u_vbb_max_um, 5.0);
    }

    #[test]
    fn a_row_that_is_no_reading_is_named_by_its_line() {
        let refused =
            |from: &str, to: &str| read_history(TEXT.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(refused("70.5", "-1").contains("line 3"));
        assert!(refused("70.5", "NaN").contains("line 3"));
        assert!(refused("doubtful", "perhaps").contains("line 3"));
        assert!(refused("20.0", "9").contains("cut 9 follows cut 10"));
        let short = refused("vbb_um", "width");
        assert!(short.contains("line 1") && short.contains("no column vbb_um"), "{short}");
    }

    #[test]
    fn a_history_that_a_spreadsheet_saved_is_the_same() {
        let commas = TEXT.replace(',', ";").replace('.', ",");
        let mut wide = vec![0xff, 0xfe];
        wide.extend(commas.replace(';', "\t").encode_utf16().flat_map(u16::to_le_bytes));
        let marked = [b"\xef\xbb\xbf".as_slice(), commas.replace('\n', "\r\n").as_bytes()].concat();
        let rows = read_history(TEXT).unwrap();
        for bytes in [commas.clone().into_bytes(), format!("sep=;\n{commas}").into_bytes(), wide, marked] {
            assert_eq!(read_history(&bytes).unwrap(), rows, "{}", String::from_utf8_lossy(&bytes));
        }
        let refused = read_history(commas.replace("70,5", "70,5,1")).unwrap_err().to_string();
        assert!(refused.contains("line 3: vbb_um '70,5,1'"), "{refused}");
    }
}
