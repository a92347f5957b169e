//! Files of the studies: configs in, a folder with tables, plots and a page out.

use std::path::Path;

use schemars::JsonSchema;
use serde::de::DeserializeOwned;

use super::failure::{CommandResult, Failure, Outcome};
use crate::config;
use crate::files::OutputFolder;
use crate::setting::SettingError;

/// A config's text and its name in errors.
pub(crate) struct ConfigText {
    /// The text.
    pub text: String,
    /// The file's name.
    pub name: String,
}

impl ConfigText {
    /// Reads a file.
    ///
    /// # Errors
    /// Exit 2 where it cannot be read, or is no config: not UTF-8, empty, JSON.
    pub(crate) fn read(path: &Path) -> Result<Self, Failure> {
        let text = config::read_text(path).map_err(Failure::refused)?;
        Ok(Self { text, name: path.display().to_string() })
    }

    /// Reads a file, or takes the built-in text.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub(crate) fn read_or(path: Option<&Path>, name: &str, text: &str) -> Result<Self, Failure> {
        path.map_or_else(|| Ok(Self { text: text.to_owned(), name: name.to_owned() }), Self::read)
    }

    /// Parses it.
    ///
    /// # Errors
    /// Exit 2 for an unknown key, a wrong type or text that is not TOML.
    pub(crate) fn parse<T: DeserializeOwned + JsonSchema>(&self) -> Result<T, Failure> {
        config::parse_as(&self.text, &self.name).map_err(Failure::refused)
    }

    /// Its tables, whatever they are.
    ///
    /// # Errors
    /// Exit 2 for text that is not TOML.
    pub(crate) fn tables(&self) -> Result<toml::Table, Failure> {
        config::parse_loose(&self.text, &self.name).map_err(Failure::refused)
    }

    /// A refusal of a key's value, with its place.
    pub(crate) fn refuse_at(&self, error: SettingError) -> Failure {
        Failure::refused(config::value_error(&self.text, &self.name, error))
    }

    /// A refusal of the text's contents.
    pub(crate) fn refuse(&self, error: impl std::fmt::Display) -> Failure {
        Failure::refuse(format!("{}: {error}", self.name))
    }
}

/// A folder for a study's output, which appears in its place once it is finished.
pub(crate) struct StudyFolder(OutputFolder);

impl StudyFolder {
    /// Claims a folder that is absent or empty, where one is requested.
    ///
    /// # Errors
    /// Exit 2 for one that holds anything or that another process fills, 3 for one that cannot be
    /// written.
    pub(crate) fn claim(path: Option<&Path>) -> Result<Option<Self>, Failure> {
        Ok(path.map(OutputFolder::claim).transpose()?.map(Self))
    }

    /// Fills a claimed folder and puts it in its place.
    ///
    /// # Errors
    /// As [`Self::write`].
    pub(crate) fn fill(
        folder: Option<Self>,
        write: impl FnOnce(&Self) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let Some(folder) = folder else { return Ok(()) };
        write(&folder)?;
        Ok(folder.0.finish()?)
    }

    /// Writes a file.
    ///
    /// # Errors
    /// Exit 3 where the disk or the permissions refuse.
    pub(crate) fn write(&self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        Ok(self.0.write(name, bytes)?)
    }
}

/// Rows as CSV text.
///
/// # Errors
/// Exit 3 for rows that CSV cannot represent.
pub(crate) fn csv_text<T: serde::Serialize>(rows: &[T]) -> Result<Vec<u8>, Failure> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    rows.iter().try_for_each(|row| writer.serialize(row)).map_err(Failure::fail)?;
    writer.into_inner().map_err(Failure::fail)
}

/// A row of a table of moves: the programmed point as a program's text commands it.
#[derive(serde::Serialize)]
pub(crate) struct MoveRow {
    from_diameter_mm: f64,
    from_z_mm: f64,
    to_diameter_mm: f64,
    to_z_mm: f64,
    /// `rapid`, `roughing` or `finishing`.
    kind: &'static str,
}

impl MoveRow {
    /// A move between two places (X radius, Z), mm.
    pub(crate) fn new(from: glam::DVec2, to: glam::DVec2, kind: &'static str) -> Self {
        let (from_diameter_mm, to_diameter_mm) = (2.0 * from.x, 2.0 * to.x);
        Self { from_diameter_mm, from_z_mm: from.y, to_diameter_mm, to_z_mm: to.y, kind }
    }
}

/// A value as pretty JSON.
///
/// # Errors
/// Exit 3 for values that JSON cannot represent.
pub(crate) fn json_text<T: serde::Serialize>(value: &T) -> Result<String, Failure> {
    serde_json::to_string_pretty(value).map_err(Failure::fail)
}

/// Prints a study: as JSON, or in words.
///
/// # Errors
/// As [`json_text`].
pub(crate) fn say_study<T: serde::Serialize>(
    study: &T,
    json: bool,
    in_words: impl FnOnce(&T),
) -> CommandResult {
    if json {
        say_line!("{}", json_text(study)?);
    } else {
        in_words(study);
    }
    Ok(Outcome::Done)
}
