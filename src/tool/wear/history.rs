//! The wear history of an edge: a table in CSV, a reading a row.

use super::blunt::WearVerdict;
use crate::tool::error::ToolError;

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

/// Reads a history; columns are found by name.
///
/// # Errors
/// A row that is no reading, or not after the row before it: with its line.
pub(crate) fn read_history(text: &str) -> Result<Vec<WearRow>, ToolError> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let mut rows: Vec<WearRow> = Vec::new();
    for (k, row) in reader.deserialize::<WearRow>().enumerate() {
        let line = k + 2;
        let row = row.map_err(|e| ToolError::History { line, what: e.to_string() })?;
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
            |from: &str, to: &str| read_history(&TEXT.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(refused("70.5", "-1").contains("line 3"));
        assert!(refused("70.5", "NaN").contains("line 3"));
        assert!(refused("doubtful", "perhaps").contains("line 3"));
        assert!(refused("20.0", "9").contains("cut 9 follows cut 10"));
        assert!(refused("vbb_um", "width").contains("line 2"));
    }
}
