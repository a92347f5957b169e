//! `--store` of the commands that write one.

use std::path::{Path, PathBuf};

use crate::cli::failure::Failure;
use crate::store::{Store, StoreError};

/// Where results are stored, and by whom.
#[derive(Clone, Debug, Default, clap::Args)]
pub(in crate::cli) struct StoreArgs {
    /// Stores every pass in this file (SQLite; made where it is absent), with the audit of who
    /// stored it; a pass that is there already is not stored twice.
    #[arg(long, value_name = "FILE")]
    store: Option<PathBuf>,
    /// Who stores it, for the audit (default: the user's name).
    #[arg(long, value_name = "NAME", requires = "store")]
    by: Option<String>,
}

impl StoreArgs {
    /// Opens the store, where one is given.
    ///
    /// # Errors
    /// Exit 2 for a file that is no store, or a newer one; 3 where it cannot be written.
    pub(in crate::cli) fn open(&self) -> Result<Option<Store>, Failure> {
        let open = |path: &PathBuf| Store::open(path, &who(self.by.as_deref())).map_err(failure);
        self.store.as_ref().map(open).transpose()
    }

    /// The file given.
    pub(in crate::cli) fn file(&self) -> Option<&Path> {
        self.store.as_deref()
    }
}

/// The name for the audit: the one given, else the user's.
pub(super) fn who(given: Option<&str>) -> String {
    let user = || ["USER", "LOGNAME", "USERNAME"].iter().find_map(|name| std::env::var(name).ok());
    given.map(str::to_owned).or_else(user).unwrap_or_else(|| "unknown".to_owned())
}

/// Exit 2 for a file that is wrong, 3 for a disk that fails.
pub(in crate::cli) fn failure(error: StoreError) -> Failure {
    if error.is_refusal() { Failure::refuse(error) } else { Failure::fail(error) }
}

/// Removes a store that this process made, with SQLite's files beside it.
pub(super) fn remove(path: &Path) {
    for ending in ["", "-wal", "-shm", "-journal"] {
        let mut name = path.as_os_str().to_owned();
        name.push(ending);
        // one that is absent is what is wanted
        let _ = std::fs::remove_file(name);
    }
}
