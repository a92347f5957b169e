//! Writing: a run, its passes, documents. Every call is one transaction.

use rusqlite::{Connection, OptionalExtension as _, params};

use super::audit;
use super::database::{Store, classified};
use super::error::StoreError;
use super::row::{Change, Entry, EntryKind, PassToStore, RunToStore};
use super::utc::Utc;

/// What became of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Acknowledged {
    /// It is on the disk now.
    Stored,
    /// It was there with the same values.
    WasThere,
}

/// A pass that is there with other values, or a failure.
enum Refused {
    Contradiction(u32),
    Failed(rusqlite::Error),
}

impl From<rusqlite::Error> for Refused {
    fn from(error: rusqlite::Error) -> Self {
        Self::Failed(error)
    }
}

impl Store {
    /// Stores a document under its name; one that is there with the same contents stays.
    ///
    /// # Errors
    /// A store that is busy, full or damaged.
    pub(crate) fn put(&mut self, entry: &Entry) -> Result<(), StoreError> {
        let (path, who) = (self.path.clone(), self.who.clone());
        let change = self.change()?;
        put(&change, &who, entry).and_then(|()| change.commit()).map_err(|e| classified(&path, &e))
    }

    /// Takes a document out; the audit keeps it. Whether it was there.
    ///
    /// # Errors
    /// As [`Self::put`].
    pub(crate) fn take_out(&mut self, kind: EntryKind, key: &str) -> Result<bool, StoreError> {
        let (path, who) = (self.path.clone(), self.who.clone());
        let change = self.change()?;
        let taken = taken_out(&change, &who, (kind.as_str(), key));
        let taken = taken.and_then(|was_there| change.commit().map(|()| was_there));
        taken.map_err(|e| classified(&path, &e))
    }

    /// Stores passes of a run in one transaction, the run too where it is new: all of them are
    /// on the disk afterwards, or none. A pass that is there with the same values stays.
    ///
    /// # Errors
    /// [`StoreError::Contradiction`] for a pass that is there with other values; a store that is
    /// busy, full or damaged.
    pub(crate) fn acknowledge(
        &mut self,
        run: &RunToStore,
        passes: &[PassToStore],
    ) -> Result<Vec<Acknowledged>, StoreError> {
        let (path, who) = (self.path.clone(), self.who.clone());
        let change = self.change()?;
        let now = Utc::now();
        let stored = run_id(&change, (&who, now), run).map_err(Refused::from).and_then(|id| {
            let store = |pass| store_pass(&change, (&who, now), (id, &run.key), pass);
            passes.iter().map(store).collect::<Result<Vec<_>, Refused>>()
        });
        let stored = stored.and_then(|all| change.commit().map(|()| all).map_err(Refused::from));
        stored.map_err(|refused| match refused {
            Refused::Contradiction(pass) => StoreError::Contradiction { path, run: run.key.clone(), pass },
            Refused::Failed(error) => classified(&path, &error),
        })
    }
}

fn put(db: &Connection, who: &str, entry: &Entry) -> rusqlite::Result<()> {
    let (kind, utc) = (entry.kind.as_str(), Utc::now());
    let sql = "SELECT document FROM entries WHERE kind = ?1 AND key = ?2";
    let old: Option<String> =
        db.prepare_cached(sql)?.query_row([kind, &entry.key], |row| row.get(0)).optional()?;
    if old.as_ref() == Some(&entry.document) {
        return Ok(());
    }
    db.prepare_cached("INSERT OR REPLACE INTO entries VALUES (?1, ?2, ?3, ?4)")?.execute(params![
        kind,
        entry.key,
        utc.0,
        entry.document
    ])?;
    let (old, new) = (old.as_deref(), Some(entry.document.as_str()));
    audit::add(db, &Change { utc, who, what: kind, key: &entry.key, old, new })
}

fn taken_out(db: &Connection, who: &str, (kind, key): (&str, &str)) -> rusqlite::Result<bool> {
    let sql = "DELETE FROM entries WHERE kind = ?1 AND key = ?2 RETURNING document";
    let old: Option<String> = db.query_row(sql, [kind, key], |row| row.get(0)).optional()?;
    let Some(old) = old else { return Ok(false) };
    let (utc, old) = (Utc::now(), Some(old.as_str()));
    audit::add(db, &Change { utc, who, what: kind, key, old, new: None })?;
    Ok(true)
}

/// The row of a run, which is made where it is new.
pub(super) fn run_id(db: &Connection, (who, utc): (&str, Utc), run: &RunToStore) -> rusqlite::Result<i64> {
    let sql = "SELECT id FROM runs WHERE key = ?1";
    if let Some(id) = db.prepare_cached(sql)?.query_row([&run.key], |row| row.get(0)).optional()? {
        return Ok(id);
    }
    let sql = "INSERT INTO runs (key, origin, name, part, tool, calibration, utc_ms, config) \
               VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)";
    db.prepare_cached(sql)?.execute(params![
        run.key,
        run.origin,
        run.name,
        run.part,
        run.tool,
        run.calibration,
        utc.0,
        run.config
    ])?;
    let id = db.last_insert_rowid();
    let new = run_text(run);
    audit::add(db, &Change { utc, who, what: "run", key: &run.key, old: None, new: Some(&new) })?;
    Ok(id)
}

/// A run as the audit has it.
pub(super) fn run_text(run: &RunToStore) -> String {
    serde_json::to_string(run).unwrap_or_default()
}

/// A pass as the audit has it.
pub(super) fn pass_text(digest: &str, stations: usize) -> String {
    format!("{{\"digest\":\"{digest}\",\"stations\":{stations}}}")
}

/// Key of a pass in the audit.
pub(super) fn pass_key(run: &str, pass: u32) -> String {
    format!("{run}/{pass}")
}

fn store_pass(
    db: &Connection,
    (who, utc): (&str, Utc),
    (run, run_key): (i64, &str),
    pass: &PassToStore,
) -> Result<Acknowledged, Refused> {
    let digest = pass.digest();
    let sql = "SELECT digest FROM passes WHERE run = ?1 AND pass = ?2";
    let there: Option<String> =
        db.prepare_cached(sql)?.query_row(params![run, pass.pass], |row| row.get(0)).optional()?;
    match there {
        Some(there) if there == digest => return Ok(Acknowledged::WasThere),
        Some(_) => return Err(Refused::Contradiction(pass.pass)),
        None => {}
    }
    let sql = "INSERT INTO passes (run, pass, name, utc_ms, digest, max_abs_error_mm) \
               VALUES (?1, ?2, ?3, ?4, ?5, ?6)";
    db.prepare_cached(sql)?.execute(params![
        run,
        pass.pass,
        pass.name,
        utc.0,
        digest,
        pass.max_abs_error_mm
    ])?;
    let id = db.last_insert_rowid();
    store_stations(db, id, pass)?;
    store_outcome(db, (id, utc), pass)?;
    let (key, new) = (pass_key(run_key, pass.pass), pass_text(&digest, pass.stations.len()));
    audit::add(db, &Change { utc, who, what: "pass", key: &key, old: None, new: Some(&new) })?;
    Ok(Acknowledged::Stored)
}

fn store_stations(db: &Connection, id: i64, pass: &PassToStore) -> rusqlite::Result<()> {
    let mut insert = db.prepare_cached("INSERT INTO stations VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)")?;
    for (k, s) in pass.stations.iter().enumerate() {
        insert.execute(params![id, k as i64, s.z_mm, s.nominal_mm, s.d_mm, s.u_mm, s.flag])?;
    }
    Ok(())
}

fn store_outcome(db: &Connection, (id, utc): (i64, Utc), pass: &PassToStore) -> rusqlite::Result<()> {
    if let Some([decision, reason, offsets]) = &pass.decision {
        db.prepare_cached("INSERT INTO decisions VALUES (?1, ?2, ?3, ?4)")?
            .execute(params![id, decision, reason, offsets])?;
    }
    if let Some(words) = &pass.alarm {
        db.prepare_cached("INSERT INTO alarms (pass, utc_ms, words) VALUES (?1, ?2, ?3)")?
            .execute(params![id, utc.0, words])?;
    }
    Ok(())
}
