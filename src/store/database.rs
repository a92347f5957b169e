//! The file: opened, separated from other files, migrated, and what its failures are.

use std::path::{Path, PathBuf};
use std::time::Duration;

use rusqlite::{Connection, ErrorCode, OpenFlags, Transaction, TransactionBehavior, ffi};

use super::error::StoreError;
use super::schema::{APPLICATION_ID, MIGRATIONS, newest};

/// How long another process's transaction is waited for: a pass is written within milliseconds, a
/// large import or prune within seconds.
const BUSY_S: u64 = 10;

/// A store that is open.
#[derive(Debug)]
pub(crate) struct Store {
    pub(super) path: PathBuf,
    pub(super) db: Connection,
    /// Who changes it, for the audit.
    pub(super) who: String,
}

impl Store {
    /// Opens a store, or makes one where no file is; `who` is noted with every change.
    ///
    /// # Errors
    /// Another kind of file, a newer schema, a store that cannot be written.
    pub(crate) fn open(path: &Path, who: &str) -> Result<Self, StoreError> {
        let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_CREATE;
        let mut store = Self::connect(path, flags, who)?;
        store.recognise()?;
        store.set("journal_mode", "WAL")?;
        // every acknowledged pass survives a power cut (FULL: the log is synced at each commit)
        store.set("synchronous", "FULL")?;
        store.set("foreign_keys", "ON")?;
        store.migrate()?;
        Ok(store)
    }

    /// Opens a store that is there, to read.
    ///
    /// # Errors
    /// As [`Self::open`], and a file that is absent.
    pub(crate) fn read(path: &Path) -> Result<Self, StoreError> {
        if !path.is_file() {
            return Err(StoreError::Absent { path: path.into(), what: "there is no such file".into() });
        }
        let store = Self::connect(path, OpenFlags::SQLITE_OPEN_READ_ONLY, "")?;
        match store.recognise()? {
            0 => Err(StoreError::Absent { path: path.into(), what: "it is empty".into() }),
            _ => Ok(store),
        }
    }

    fn connect(path: &Path, flags: OpenFlags, who: &str) -> Result<Self, StoreError> {
        let flags = flags | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let named = |e: rusqlite::Error| classified(path, &e);
        let db = Connection::open_with_flags(path, flags).map_err(named)?;
        db.busy_timeout(Duration::from_secs(BUSY_S)).map_err(named)?;
        Ok(Self { path: path.into(), db, who: who.to_owned() })
    }

    fn set(&self, name: &str, value: &str) -> Result<(), StoreError> {
        self.db.pragma_update(None, name, value).map_err(|e| self.failure(&e))
    }

    /// The schema of the file; 0 of a new one.
    fn recognise(&self) -> Result<i64, StoreError> {
        let number = |name: &str| {
            self.db.pragma_query_value(None, name, |row| row.get::<_, i64>(0)).map_err(|e| self.failure(&e))
        };
        let foreign =
            |what: &str| Err(StoreError::Foreign { path: self.path.clone(), what: what.to_owned() });
        let (application, version) = (number("application_id")?, number("user_version")?);
        let tables = "SELECT count(*) FROM sqlite_schema";
        let tables: i64 = self.db.query_row(tables, [], |row| row.get(0)).map_err(|e| self.failure(&e))?;
        match (application, version) {
            (0, 0) if tables == 0 => Ok(0),
            (APPLICATION_ID, found) if found > newest() => {
                Err(StoreError::Newer { path: self.path.clone(), found, known: newest() })
            }
            (APPLICATION_ID, found) => Ok(found),
            _ => foreign("a SQLite database of another program"),
        }
    }

    fn migrate(&mut self) -> Result<(), StoreError> {
        let path = self.path.clone();
        let named = |e: rusqlite::Error| classified(&path, &e);
        let change = self.change()?;
        let version: i64 =
            change.pragma_query_value(None, "user_version", |row| row.get(0)).map_err(named)?;
        for sql in MIGRATIONS.iter().skip(version.max(0).cast_unsigned() as usize) {
            change.execute_batch(sql).map_err(named)?;
        }
        if version < newest() {
            change.pragma_update(None, "application_id", APPLICATION_ID).map_err(named)?;
            change.pragma_update(None, "user_version", newest()).map_err(named)?;
        }
        change.commit().map_err(named)
    }

    /// Begins a change: the only one at this time in any process.
    pub(super) fn change(&mut self) -> Result<Transaction<'_>, StoreError> {
        let path = self.path.clone();
        self.db.transaction_with_behavior(TransactionBehavior::Immediate).map_err(|e| classified(&path, &e))
    }

    pub(super) fn failure(&self, error: &rusqlite::Error) -> StoreError {
        classified(&self.path, error)
    }
}

/// A failure in words.
pub(super) fn classified(path: &Path, error: &rusqlite::Error) -> StoreError {
    let path = path.to_path_buf();
    match error.sqlite_error_code() {
        Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked) => {
            StoreError::Busy { path, seconds: BUSY_S }
        }
        Some(ErrorCode::DiskFull) => StoreError::Full { path },
        Some(ErrorCode::ReadOnly) => StoreError::Unwritable {
            path,
            cause: "its file, its folder or their disk is read-only; make it writable or name another with --store",
        },
        Some(ErrorCode::CannotOpen) => StoreError::Unwritable {
            path,
            cause: "its folder is absent or this user has no right to it; make it or name another with --store",
        },
        Some(ErrorCode::SystemIoFailure) => disk(path, error),
        Some(ErrorCode::NotADatabase) => StoreError::Foreign { path, what: "no SQLite database".into() },
        Some(ErrorCode::DatabaseCorrupt) => StoreError::Database {
            path,
            cause: format!("is damaged ({error}); `store export` saves what can be read"),
        },
        _ => StoreError::Database { path, cause: error.to_string() },
    }
}

/// What the disk refused: SQLite has writing, syncing and reading as extended codes.
fn disk(path: PathBuf, error: &rusqlite::Error) -> StoreError {
    let extended = error.sqlite_error().map(|e| e.extended_code);
    let (what, likely) = match extended {
        // also EFBIG: SQLite names ENOSPC and EDQUOT alone as full
        Some(ffi::SQLITE_IOERR_WRITE | ffi::SQLITE_IOERR_TRUNCATE) => {
            ("written", "a limit of the file's length (ulimit -f) or a fault of the disk")
        }
        Some(ffi::SQLITE_IOERR_FSYNC | ffi::SQLITE_IOERR_DIR_FSYNC) => ("synced", "a fault of the disk"),
        Some(ffi::SQLITE_IOERR_SHMSIZE | ffi::SQLITE_IOERR_SHMOPEN | ffi::SQLITE_IOERR_SHMMAP) => {
            ("locked", "a full disk, or one that shares no memory between processes")
        }
        _ => ("read", "a fault of the disk"),
    };
    StoreError::Disk { path, what, cause: format!("{likely}: {error}") }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::Store;
    use crate::store::error::StoreError;
    use crate::store::row::{PassToStore, RunToStore, StationToStore};

    fn run() -> RunToStore {
        let (key, origin, name, config) = ("k".into(), "run".into(), "n".into(), String::new());
        RunToStore { key, origin, name, part: None, tool: None, calibration: None, config }
    }

    fn pass(pass: u32, stations: usize) -> PassToStore {
        PassToStore { pass, stations: vec![StationToStore::default(); stations], ..PassToStore::default() }
    }

    /// A limit of pages is what a full disk is to SQLite.
    #[test]
    fn of_a_pass_that_the_disk_has_no_room_for_nothing_is_stored() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::open(&folder.path().join("s.sqlite"), "Ada").unwrap();
        store.acknowledge(&run(), &[pass(1, 10)]).unwrap();
        let pages: i64 = store.db.pragma_query_value(None, "page_count", |row| row.get(0)).unwrap();
        store.db.pragma_update_and_check(None, "max_page_count", pages + 2, |_| Ok(())).unwrap();
        let full = store.acknowledge(&run(), &[pass(2, 10), pass(3, 10_000)]).unwrap_err();
        assert!(matches!(full, StoreError::Full { .. }), "{full}");
        assert_eq!(store.counts().unwrap().passes, 1);
        assert!(store.check(None).unwrap().findings.is_empty());
    }

    #[test]
    fn failures_of_the_disk_are_told_apart() {
        let failed = |code: std::ffi::c_int| {
            let error = rusqlite::Error::SqliteFailure(rusqlite::ffi::Error::new(code), None);
            super::classified(std::path::Path::new("s.sqlite"), &error).to_string()
        };
        use rusqlite::ffi;
        for (code, words) in [
            (ffi::SQLITE_FULL, "the disk is full"),
            (ffi::SQLITE_READONLY, "read-only"),
            (ffi::SQLITE_CANTOPEN, "its folder is absent"),
            (ffi::SQLITE_IOERR_WRITE, "ulimit -f"),
            (ffi::SQLITE_IOERR_FSYNC, "synced"),
            (ffi::SQLITE_IOERR_READ, "was read"),
            (ffi::SQLITE_CORRUPT, "is damaged"),
        ] {
            let said = failed(code);
            assert!(said.contains(words) && said.contains("s.sqlite"), "{code}: {said}");
        }
    }

    #[test]
    fn a_store_that_another_process_writes_is_named_busy() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.sqlite");
        let (mut one, mut two) = (Store::open(&path, "Ada").unwrap(), Store::open(&path, "Bob").unwrap());
        two.db.busy_timeout(Duration::from_millis(1)).unwrap();
        let held = one.change().unwrap();
        let busy = two.acknowledge(&run(), &[pass(1, 1)]).unwrap_err();
        assert!(matches!(busy, StoreError::Busy { .. }), "{busy}");
        held.commit().unwrap();
        two.acknowledge(&run(), &[pass(1, 1)]).unwrap();
    }
}
