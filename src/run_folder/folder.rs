//! The folder itself: claiming, lock, files.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use thiserror::Error;

use crate::files::{self, LOCK_NAME, Lock, OutputError, TEMPORARY};

/// Why a run folder cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub(crate) enum RunFolderError {
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
        /// The underlying cause.
        cause: io::Error,
    },
    /// Another run writes in the folder, or a file of it cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A file of the folder cannot be read.
    #[error("{}: cannot be read: {cause}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The underlying cause.
        cause: String,
    },
}

/// A run folder that this process reads, or has locked and writes to.
#[derive(Clone, Debug)]
pub(crate) struct RunFolder {
    path: PathBuf,
    /// Held until the last copy is dropped.
    lock: Option<Arc<Lock>>,
}

const HASH_LINE: &str = "# config sha256 ";

impl RunFolder {
    /// Claims `path` for a run of the config `resolved_toml` with this hash, or resumes an
    /// unfinished run of the same hash.
    ///
    /// # Errors
    /// [`RunFolderError::Taken`] for anything else in the folder; [`RunFolderError::Output`] where
    /// another run writes in it or it cannot be made.
    pub(crate) fn claim(path: &Path, hash: &str, resolved_toml: &str) -> Result<Self, RunFolderError> {
        let mut folder = Self::unlocked(path);
        if path == Path::new("-") {
            return Err(folder.taken("is stdout".to_owned()));
        }
        folder.check_free(hash)?;
        files::make_folder(path)?;
        folder.lock = Some(Arc::new(Lock::take(&path.join(LOCK_NAME), path)?));
        // Its last holder may have written since.
        let free = folder.check_free(hash)?;
        files::clear_temporary(path)?;
        if free {
            folder.write("run.toml", format!("{HASH_LINE}{hash}\n{resolved_toml}").as_bytes())?;
        }
        Ok(folder)
    }

    /// Whether the folder is empty; an unfinished run of this hash may be resumed.
    fn check_free(&self, hash: &str) -> Result<bool, RunFolderError> {
        let what = match self.state()? {
            State::Free => return Ok(true),
            State::Run { hash: found, finished: false } if found == hash => return Ok(false),
            State::Run { finished: true, .. } => "holds a finished run".to_owned(),
            State::Run { hash: found, .. } => {
                format!("holds an unfinished run of another config (hash {}…)", prefix(&found))
            }
            State::Other(name) => format!("is not empty and holds no run (found {name})"),
        };
        Err(self.taken(what))
    }

    fn taken(&self, what: String) -> RunFolderError {
        RunFolderError::Taken { path: self.path.clone(), what }
    }

    fn unlocked(path: &Path) -> Self {
        Self { path: path.to_owned(), lock: None }
    }

    /// Empties a run folder whose config `may_go`; any other stays as it is.
    ///
    /// # Errors
    /// Where another run writes in it, or the disk or the permissions refuse.
    pub(crate) fn clear(path: &Path, may_go: impl Fn(&str) -> bool) -> Result<(), RunFolderError> {
        if !Self::is_run(path) {
            return Ok(());
        }
        let _lock = Lock::take(&path.join(LOCK_NAME), path)?;
        if Self::is_run(path) && may_go(&Self::open(path)?.config_text()?) {
            files::clear(path)?;
        }
        Ok(())
    }

    /// Opens a folder for reading.
    ///
    /// # Errors
    /// Where it holds no run.
    pub(crate) fn open(path: &Path) -> Result<Self, RunFolderError> {
        let folder = Self::unlocked(path);
        match folder.state()? {
            State::Run { .. } => Ok(folder),
            _ => Err(RunFolderError::Read {
                path: path.join("run.toml"),
                cause: "no run folder; give one that `shadowgauge run --out` has written".to_owned(),
            }),
        }
    }

    /// Whether the folder holds nothing but a run of this program, finished or not: `demo` may
    /// replace it.
    pub(crate) fn is_run(path: &Path) -> bool {
        matches!(Self::unlocked(path).state(), Ok(State::Run { .. }))
    }

    /// The folder's path.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// The files that lie in the folder itself.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(&self.path).into_iter().flatten().filter_map(Result::ok);
        entries.map(|entry| entry.path()).filter(|path| path.is_file()).collect()
    }

    /// The resolved config as written in `run.toml`.
    ///
    /// # Errors
    /// Where the file cannot be read.
    pub(crate) fn config_text(&self) -> Result<String, RunFolderError> {
        self.read_text("run.toml")
    }

    /// Writes `name` (which may contain folders) under a temporary name and renames it.
    ///
    /// # Errors
    /// Where the disk or the permissions refuse.
    pub(crate) fn write(&self, name: &str, bytes: &[u8]) -> Result<(), RunFolderError> {
        Ok(files::replace(&self.path.join(name), bytes)?)
    }

    /// Reads a text file of the folder.
    ///
    /// # Errors
    /// Where it cannot be read.
    pub(crate) fn read_text(&self, name: &str) -> Result<String, RunFolderError> {
        let path = self.path.join(name);
        std::fs::read_to_string(&path).map_err(|e| RunFolderError::Read { path, cause: e.to_string() })
    }

    fn state(&self) -> Result<State, RunFolderError> {
        let entries = match std::fs::read_dir(&self.path) {
            Ok(entries) => entries,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(State::Free),
            Err(e) if e.kind() == io::ErrorKind::NotADirectory && self.path.exists() => {
                return Ok(State::Other("no folder".to_owned()));
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
