//! An error's table in a file of text.

use std::io::Read;

use crate::setting::SettingError;

/// Columns of a table: positions (mm or degrees), values and, where measured apart, those of the
/// way back (µm or µrad).
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Columns {
    /// Positions.
    pub position: Vec<f64>,
    /// Values.
    pub forward: Vec<f64>,
    /// Values of the way back; none where the file has no such column.
    pub backward: Vec<f64>,
}

/// Reads CSV text with a header: a position, a value and, of a slide, a backward value by their
/// `names`; comments begin with `#`, further columns are passed over. `key` names the file in the
/// config.
///
/// # Errors
/// A missing column (with the unit that it must have), and a cell that is not a finite number, with
/// its line.
pub(crate) fn read_columns(from: impl Read, key: &str, names: &[String; 3]) -> Result<Columns, SettingError> {
    let refuse = |problem: String| SettingError::at(key, problem);
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(from);
    let header = reader.headers().map_err(|e| refuse(e.to_string()))?.clone();
    let place = |name: &String| header.iter().position(|found| found == name);
    let needed = |name: &String| {
        let found = header.iter().collect::<Vec<_>>().join(",");
        place(name).ok_or_else(|| {
            refuse(format!(
                "has no column {name}, only '{found}'; its header must be {},{}",
                names[0], names[1]
            ))
        })
    };
    let (position, forward, backward) = (needed(&names[0])?, needed(&names[1])?, place(&names[2]));
    let mut columns = Columns::default();
    for record in reader.records() {
        let record = record.map_err(|e| refuse(e.to_string()))?;
        let line = record.position().map_or(0, csv::Position::line);
        let number = |k: usize| match record.get(k).unwrap_or_default().parse::<f64>() {
            Ok(v) if v.is_finite() => Ok(v),
            _ => {
                let found = record.get(k).unwrap_or_default();
                Err(refuse(format!("line {line}: '{found}' must be a finite number")))
            }
        };
        columns.position.push(number(position)?);
        columns.forward.push(number(forward)?);
        if let Some(backward) = backward {
            columns.backward.push(number(backward)?);
        }
    }
    Ok(columns)
}
