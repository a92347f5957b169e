//! Reading: stations by the time of their pass.

use rusqlite::{OptionalExtension as _, params};
use serde::Serialize;

use super::audit;
use super::database::Store;
use super::error::StoreError;
use super::row::{EntryKind, StationToStore};
use super::utc::Utc;

/// A station with what it belongs to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct StoredRow {
    /// When its pass was stored, ISO 8601.
    pub utc: String,
    /// Key of its run.
    pub run: String,
    /// Name of its run.
    pub name: String,
    /// Its pass, from 1.
    pub pass: u32,
    /// Name of its frame, of a measurement.
    pub frame: Option<String>,
    /// The station.
    #[serde(flatten)]
    pub station: StationToStore,
}

/// Passes and stations of a store.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct Counts {
    /// Runs.
    pub runs: i64,
    /// Passes.
    pub passes: i64,
    /// Stations.
    pub stations: i64,
}

impl Store {
    /// Calls `each` with the stations of passes stored from `from` on and before `to`, by time, and
    /// along the part.
    ///
    /// # Errors
    /// A store that is busy or damaged.
    pub(crate) fn stations_between(
        &self,
        from: Utc,
        to: Utc,
        mut each: impl FnMut(StoredRow),
    ) -> Result<(), StoreError> {
        let mut read = || {
            let sql = "SELECT p.utc_ms, r.key, r.name, p.pass, p.name, s.z_mm, s.nominal_mm, s.d_mm, s.u_mm, s.flag \
                       FROM passes p JOIN runs r ON r.id = p.run JOIN stations s ON s.pass = p.id \
                       WHERE p.utc_ms >= ?1 AND p.utc_ms < ?2 ORDER BY p.utc_ms, p.id, s.station";
            let mut query = self.db.prepare_cached(sql)?;
            let mut rows = query.query(params![from.0, to.0])?;
            while let Some(row) = rows.next()? {
                each(StoredRow {
                    utc: Utc(row.get(0)?).to_string(),
                    run: row.get(1)?,
                    name: row.get(2)?,
                    pass: row.get(3)?,
                    frame: row.get(4)?,
                    station: StationToStore {
                        z_mm: row.get(5)?,
                        nominal_mm: row.get(6)?,
                        d_mm: row.get(7)?,
                        u_mm: row.get(8)?,
                        flag: row.get(9)?,
                    },
                });
            }
            Ok(())
        };
        read().map_err(|e: rusqlite::Error| self.failure(&e))
    }

    /// A document by its name.
    ///
    /// # Errors
    /// As [`Self::stations_between`].
    pub(crate) fn entry(&self, kind: EntryKind, key: &str) -> Result<Option<String>, StoreError> {
        let sql = "SELECT document FROM entries WHERE kind = ?1 AND key = ?2";
        let read = self.db.query_row(sql, [kind.as_str(), key], |row| row.get(0)).optional();
        read.map_err(|e| self.failure(&e))
    }

    /// Documents of a kind, by their names, and how many there are in all.
    ///
    /// # Errors
    /// As [`Self::stations_between`].
    pub(crate) fn entries(
        &self,
        kind: EntryKind,
        (offset, limit): (usize, usize),
    ) -> Result<(usize, Vec<String>), StoreError> {
        let read = || {
            let (count, page) = (
                "SELECT count(*) FROM entries WHERE kind = ?1",
                "SELECT document FROM entries WHERE kind = ?1 ORDER BY key LIMIT ?2 OFFSET ?3",
            );
            let total: i64 = self.db.query_row(count, [kind.as_str()], |row| row.get(0))?;
            let mut query = self.db.prepare_cached(page)?;
            let bounds = params![kind.as_str(), limit as i64, offset as i64];
            let all =
                query.query_map(bounds, |row| row.get(0))?.collect::<rusqlite::Result<Vec<String>>>()?;
            Ok((total.max(0).cast_unsigned() as usize, all))
        };
        read().map_err(|e: rusqlite::Error| self.failure(&e))
    }

    /// Documents of a kind with the time when each was stored, the newest first.
    ///
    /// # Errors
    /// As [`Self::stations_between`].
    pub(crate) fn newest(&self, kind: EntryKind, limit: usize) -> Result<Vec<(Utc, String)>, StoreError> {
        let read = || {
            let sql =
                "SELECT utc_ms, document FROM entries WHERE kind = ?1 ORDER BY utc_ms DESC, key LIMIT ?2";
            let mut query = self.db.prepare_cached(sql)?;
            let rows = query
                .query_map(params![kind.as_str(), limit as i64], |row| Ok((Utc(row.get(0)?), row.get(1)?)))?;
            rows.collect::<rusqlite::Result<Vec<_>>>()
        };
        read().map_err(|e: rusqlite::Error| self.failure(&e))
    }

    /// Number and hash of the newest row of the audit.
    ///
    /// # Errors
    /// As [`Self::stations_between`].
    pub(crate) fn newest_row(&self) -> Result<(i64, String), StoreError> {
        audit::head(&self.db).map_err(|e| self.failure(&e))
    }

    /// How much it holds.
    ///
    /// # Errors
    /// As [`Self::stations_between`].
    pub(crate) fn counts(&self) -> Result<Counts, StoreError> {
        let count =
            |table: &str| self.db.query_row(&format!("SELECT count(*) FROM {table}"), [], |row| row.get(0));
        let read =
            || Ok(Counts { runs: count("runs")?, passes: count("passes")?, stations: count("stations")? });
        read().map_err(|e: rusqlite::Error| self.failure(&e))
    }
}
