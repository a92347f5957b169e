//! Why a store cannot be used.

use std::path::PathBuf;

use thiserror::Error;

/// Why a store cannot be used.
#[derive(Debug, Error)]
pub(crate) enum StoreError {
    /// The file is something else.
    #[error("{}: is no store: {what}; right would be an absent file or one that --store has made", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What it is.
        what: String,
    },
    /// There is nothing to read.
    #[error("{}: is no store to read: {what}; right would be a file that --store has made", path.display())]
    Absent {
        /// The file.
        path: PathBuf,
        /// Why not.
        what: String,
    },
    /// A newer program has written it.
    #[error("{}: has schema {found}, this program knows schemas up to {known}: read it with the newer program", path.display())]
    Newer {
        /// The file.
        path: PathBuf,
        /// Its schema.
        found: i64,
        /// The newest schema known.
        known: i64,
    },
    /// Another process writes.
    #[error("{}: another process writes to it and did not end within {seconds} s; nothing was stored", path.display())]
    Busy {
        /// The file.
        path: PathBuf,
        /// How long was waited, s.
        seconds: u64,
    },
    /// No space is left.
    #[error("{}: the disk is full; nothing of this pass was stored", path.display())]
    Full {
        /// The file.
        path: PathBuf,
    },
    /// It may not be written.
    #[error("{}: cannot be written: {cause}; nothing was stored", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// Why: rights, a disk that is read-only.
        cause: &'static str,
    },
    /// The disk refuses.
    #[error("{}: the disk failed while it was {what} ({cause}); nothing of this pass was stored", path.display())]
    Disk {
        /// The file.
        path: PathBuf,
        /// What was done.
        what: &'static str,
        /// What is likely, and the library's words.
        cause: String,
    },
    /// The pass is there with other values.
    #[error("{}: pass {pass} of run {run} is stored with other values; a store is never overwritten: give another \
             file, or another seed or config", path.display())]
    Contradiction {
        /// The file.
        path: PathBuf,
        /// Key of the run.
        run: String,
        /// The pass, from 1.
        pass: u32,
    },
    /// A line of an export.
    #[error("{}, line {line}: {what}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// Its line, from 1.
        line: usize,
        /// What is wrong.
        what: String,
    },
    /// Anything else.
    #[error("{}: {cause}", path.display())]
    Database {
        /// The file.
        path: PathBuf,
        /// The underlying cause.
        cause: String,
    },
}

impl StoreError {
    /// Whether the file given is wrong, rather than the disk.
    pub(crate) fn is_refusal(&self) -> bool {
        matches!(
            self,
            Self::Foreign { .. }
                | Self::Absent { .. }
                | Self::Newer { .. }
                | Self::Contradiction { .. }
                | Self::Busy { .. }
        )
    }
}
