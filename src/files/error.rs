//! Why an output is not written.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why an output is not written. All but [`OutputError::Failed`] are refusals.
#[derive(Debug, Error)]
#[non_exhaustive]
pub(crate) enum OutputError {
    /// Something exists there that must not be replaced.
    #[error("{}: {what}", path.display())]
    Refused {
        /// The output.
        path: PathBuf,
        /// What it is, and a remedy.
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
        /// The underlying cause.
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

    /// Whether the error lies in the command line, not in the disk.
    pub(crate) fn is_refusal(&self) -> bool {
        !matches!(self, Self::Failed { .. })
    }
}
