//! A run on disk: written pass by pass, resumed after a kill, read by `report` and `nc`.
//!
//! Every file is written under a temporary name and renamed. `passes.csv` is written last of a pass, so a pass that
//! stands in it has all its data; whatever a killed run left of a later pass is overwritten. `report.html` is written
//! last of all: a folder that has one is finished and never touched again.

mod control;
mod form_tables;
mod parquet_file;
mod tables;

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

pub use control::{ControlRecord, PassRecord};
pub use form_tables::{FormRow, PartFormRow};
pub use parquet_file::{DiameterRow, TruthRow, read_diameters};
pub use tables::{OffsetRow, PassRow, StationRow, offset_of, profile_of};

/// Why a run folder cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RunFolderError {
    /// The folder holds something else, or a finished run.
    #[error("{}: {what}; give a folder that is absent or empty", path.display())]
    Taken {
        /// The folder.
        path: PathBuf,
        /// What is there.
        what: String,
    },
    /// A file of the folder cannot be written.
    #[error("{}: cannot be written: {cause}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The cause underneath.
        cause: io::Error,
    },
    /// A file of the folder cannot be read.
    #[error("{}: cannot be read: {cause}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The cause underneath.
        cause: String,
    },
}

/// A run folder that this process writes to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunFolder {
    path: PathBuf,
}

const HASH_LINE: &str = "# config sha256 ";

impl RunFolder {
    /// Claims `path` for a run of the config `resolved_toml` with this hash, or takes up an unfinished run of the same hash.
    ///
    /// # Errors
    /// [`RunFolderError::Taken`] for anything else in the folder; [`RunFolderError::Write`] where it cannot be made.
    pub fn claim(path: &Path, hash: &str, resolved_toml: &str) -> Result<Self, RunFolderError> {
        let folder = Self { path: path.to_owned() };
        match folder.state()? {
            State::Free => {
                std::fs::create_dir_all(path)
                    .map_err(|cause| RunFolderError::Write { path: path.to_owned(), cause })?;
                folder.write("run.toml", format!("{HASH_LINE}{hash}\n{resolved_toml}").as_bytes())?;
            }
            State::Run { hash: found, finished: false } if found == hash => {}
            State::Run { hash: found, finished } => {
                let what = match (finished, found == hash) {
                    (true, _) => "holds a finished run".to_owned(),
                    (false, _) => {
                        format!("holds an unfinished run of another config (hash {}…)", prefix(&found))
                    }
                };
                return Err(RunFolderError::Taken { path: path.to_owned(), what });
            }
            State::Other(name) => {
                let what = format!("is not empty and holds no run (found {name})");
                return Err(RunFolderError::Taken { path: path.to_owned(), what });
            }
        }
        Ok(folder)
    }

    /// Opens a folder to read.
    ///
    /// # Errors
    /// Where it holds no run.
    pub fn open(path: &Path) -> Result<Self, RunFolderError> {
        let folder = Self { path: path.to_owned() };
        match folder.state()? {
            State::Run { .. } => Ok(folder),
            _ => Err(RunFolderError::Read {
                path: path.join("run.toml"),
                cause: "no run folder; give one that `shadowgauge run --out` has written".to_owned(),
            }),
        }
    }

    /// Whether the folder holds nothing but a run of this program, finished or not: `demo` may replace it.
    pub fn is_run(path: &Path) -> bool {
        matches!(Self { path: path.to_owned() }.state(), Ok(State::Run { .. }))
    }

    /// The folder's path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The resolved config as written in `run.toml`.
    ///
    /// # Errors
    /// Where the file cannot be read.
    pub fn config_text(&self) -> Result<String, RunFolderError> {
        self.read_text("run.toml")
    }

    /// Writes `name` (which may have folders) under a temporary name and renames it.
    ///
    /// # Errors
    /// Where the disk or the permissions refuse.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), RunFolderError> {
        write_atomically(&self.path.join(name), bytes)
    }

    /// Reads a text file of the folder.
    ///
    /// # Errors
    /// Where it cannot be read.
    pub fn read_text(&self, name: &str) -> Result<String, RunFolderError> {
        let path = self.path.join(name);
        std::fs::read_to_string(&path).map_err(|e| RunFolderError::Read { path, cause: e.to_string() })
    }

    fn state(&self) -> Result<State, RunFolderError> {
        let entries = match std::fs::read_dir(&self.path) {
            Ok(entries) => entries,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(State::Free),
            Err(e) if e.kind() == io::ErrorKind::NotADirectory && self.path.is_file() => {
                return Ok(State::Other("a file".to_owned()));
            }
            Err(e) if e.kind() == io::ErrorKind::NotADirectory => return Ok(State::Free),
            Err(cause) => return Err(RunFolderError::Write { path: self.path.clone(), cause }),
        };
        let mut names: Vec<String> = entries
            .filter_map(Result::ok)
            .map(|e| e.file_name().to_string_lossy().into_owned())
            .filter(|name| !name.starts_with(TEMPORARY))
            .collect();
        names.sort();
        if names.iter().any(|n| n == "run.toml") {
            let text = self.read_text("run.toml")?;
            let hash =
                text.lines().next().and_then(|l| l.strip_prefix(HASH_LINE)).unwrap_or_default().to_owned();
            return Ok(State::Run { hash, finished: names.iter().any(|n| n == "report.html") });
        }
        Ok(names.into_iter().next().map_or(State::Free, State::Other))
    }
}

enum State {
    Free,
    Run { hash: String, finished: bool },
    Other(String),
}

fn prefix(hash: &str) -> &str {
    hash.get(..8).unwrap_or(hash)
}

const TEMPORARY: &str = ".tmp-";

/// Writes a file under a temporary name beside its place and renames it; makes the folder above it.
///
/// # Errors
/// Where the disk or the permissions refuse; nothing half-written stays under `path`.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), RunFolderError> {
    let failed = |cause| RunFolderError::Write { path: path.to_owned(), cause };
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(failed)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let temporary = folder.join(format!("{TEMPORARY}{name}"));
    std::fs::write(&temporary, bytes).and_then(|()| std::fs::rename(&temporary, path)).map_err(|cause| {
        std::fs::remove_file(&temporary).ok();
        failed(cause)
    })
}
