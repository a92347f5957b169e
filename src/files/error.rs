//! Why an output is not written.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why an output is not written. All but [`OutputError::Failed`] are refusals.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OutputError {
    /// Something stands there that must not be replaced.
    #[error("{}: {what}", path.display())]
    Refused {
        /// The output.
        path: PathBuf,
        /// What it is, and what would be right.
        what: String,
    },
    /// Another process writes it.
    #[error("{}: is being written by {holder}; wait for it to end, or give another output", path.display())]
    Held {
        /// The output.
        path: PathBuf,
        /// The process.
        holder: String,
    },
    /// The disk or the permissions refuse.
    #[error("{}: cannot be written: {cause}", path.display())]
    Failed {
        /// The output.
        path: PathBuf,
        /// The cause underneath.
        cause: io::Error,
    },
}

impl OutputError {
    pub(super) fn refused(path: &Path, what: impl Into<String>) -> Self {
        Self::Refused { path: path.to_owned(), what: what.into() }
    }

    pub(super) fn failed(path: &Path) -> impl FnOnce(io::Error) -> Self + '_ {
        |cause| Self::Failed { path: path.to_owned(), cause }
    }

    /// Whether the command line is at fault, and not the disk.
    pub fn is_refusal(&self) -> bool {
        !matches!(self, Self::Failed { .. })
    }
}
