//! The last check of the store: what it found, and whether the files are still as they were then.
//! A check reads all of the store, so that it is made once for as long as nothing is written.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use serde::Serialize;
use utoipa::ToSchema;

use crate::store::Utc;

/// Whether the store is what was written into it.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct StoreState {
    /// Rows of the audit.
    pub audit_rows: i64,
    /// Hash of the newest row.
    pub head: String,
    /// What does not fit together.
    pub findings: Vec<String>,
    /// Runs.
    pub runs: i64,
    /// Passes.
    pub passes: i64,
    /// Stations.
    pub stations: i64,
}

/// Length and time of the last change of the file and its log: every commit changes one of them,
/// also one of another process, and so does an alteration that no audit has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FileState([(u64, Option<SystemTime>); 2]);

impl FileState {
    /// The state of a store's files now.
    pub(super) fn of(path: &Path) -> Self {
        let mut log = path.as_os_str().to_owned();
        log.push("-wal");
        let log = PathBuf::from(log);
        Self([path, &log].map(|path| match std::fs::metadata(path) {
            // a log that is empty is as one that is absent: readers make it
            Ok(file) if file.len() > 0 => (file.len(), file.modified().ok()),
            _ => (0, None),
        }))
    }

    /// Length of both, bytes.
    pub(super) fn bytes(&self) -> u64 {
        self.0.iter().map(|(bytes, _)| bytes).sum()
    }
}

/// A check.
#[derive(Clone, Debug)]
pub(super) struct Checked {
    /// The files before it.
    pub of: FileState,
    /// When it was made.
    pub utc: Utc,
    /// What it found.
    pub found: StoreState,
}

#[cfg(test)]
mod tests {
    use super::FileState;
    use crate::store::{Entry, EntryKind, Store};

    #[test]
    fn a_store_that_is_read_is_unchanged_and_one_that_is_written_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.sqlite");
        let entry = |key: &str| Entry { kind: EntryKind::Part, key: key.into(), document: "{}".into() };
        Store::open(&path, "Ada").unwrap().put(&entry("a")).unwrap();
        let before = FileState::of(&path);
        assert!(before.bytes() > 0);
        Store::read(&path).unwrap().check(None).unwrap();
        assert_eq!(FileState::of(&path), before);
        // also while the writer still has it open, when only the log has changed
        let mut open = Store::open(&path, "Ada").unwrap();
        open.put(&entry("b")).unwrap();
        let written = FileState::of(&path);
        assert_ne!(written, before);
        drop(open);
        let closed = FileState::of(&path);
        // an alteration of one byte beside the audit
        let mut bytes = std::fs::read(&path).unwrap();
        let last = bytes.len() - 1;
        bytes[last] ^= 1;
        std::fs::write(&path, bytes).unwrap();
        assert_ne!(FileState::of(&path), closed);
    }
}
