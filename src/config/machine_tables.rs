//! The tables that the errors of a machine name, read from beside the config.

use std::path::Path;

use crate::machine::settings::key_of;
use crate::machine::table_file::read_columns;
use crate::machine::{Axis, ErrorName, MachineSettings};
use crate::setting::SettingError;

/// Reads the files of all errors' tables; their columns replace their names.
///
/// # Errors
/// A file beside values in the config, one that cannot be read or has no such columns.
pub(crate) fn read_error_tables(machine: &mut MachineSettings, folder: &Path) -> Result<(), SettingError> {
    for (name, settings) in ErrorName::ALL.into_iter().zip(machine.errors.all_mut()) {
        let Some(file) = settings.file() else { continue };
        let key = format!("{}.table.file", key_of(name));
        let stated = settings.stated();
        if stated.table.is_some_and(|table| !table.position.is_empty() || !table.forward.is_empty()) {
            return Err(SettingError::at(key, "stands beside values in the config; give one of them"));
        }
        let path = folder.join(file);
        let from = std::fs::File::open(&path)
            .map_err(|e| SettingError::at(&key, format!("{}: cannot be read: {e}", path.display())))?;
        let suffix = stated.unit.suffix();
        let position = if name.axis() == Axis::C { "angle_deg" } else { "position_mm" };
        let names = [position.to_owned(), format!("value_{suffix}"), format!("backward_{suffix}")];
        let named = |e: SettingError| SettingError::at(e.key, format!("{}: {}", path.display(), e.problem));
        settings.fill(read_columns(from, &key, &names).map_err(named)?);
    }
    Ok(())
}
