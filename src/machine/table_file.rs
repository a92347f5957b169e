//! An error's table in a file of text.

use std::io::Read;

use crate::setting::SettingError;
use crate::text_table::{Comments, TextTable};

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

/// Reads a table of text ([`crate::text_table`]): a position, a value and, of a slide, a backward
/// value by their `names`; comments begin with `#`, further columns are passed over. `key` names
/// the file in the config.
///
/// # Errors
/// A missing column (with the unit that it must have), and a cell that is not a finite number, with
/// its line.
pub(crate) fn read_columns(
    mut from: impl Read,
    key: &str,
    names: &[String; 3],
) -> Result<Columns, SettingError> {
    let refuse = |problem: String| SettingError::at(key, problem);
    let mut bytes = Vec::new();
    from.read_to_end(&mut bytes).map_err(|e| refuse(e.to_string()))?;
    let [position, forward, backward] = [0, 1, 2].map(|k| names[k].as_str());
    let table = TextTable::parse(&bytes, &[position, forward, backward], Comments::Hash)
        .map_err(|e| refuse(e.to_string()))?;
    table.require(&[position, forward]).map_err(refuse)?;
    let has_backward = table.has(backward);
    let mut columns = Columns::default();
    for cells in table.rows() {
        let cells = cells.map_err(|e| refuse(e.to_string()))?;
        columns.position.push(cells.number(position).map_err(refuse)?);
        columns.forward.push(cells.number(forward).map_err(refuse)?);
        if has_backward {
            columns.backward.push(cells.number(backward).map_err(refuse)?);
        }
    }
    Ok(columns)
}
