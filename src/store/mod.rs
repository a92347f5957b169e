//! A store that remembers: parts, runs, passes, stations, calibrations, tools, decisions, alarms
//! and who changed what, in one SQLite file.
//!
//! In: finished passes ([`PassToStore`]) and documents ([`Entry`]). Out: the same rows by time
//! ([`Store::stations_between`]), as JSON Lines (`exchange`), and what does not fit together
//! (`check`). A pass is one transaction with a digest of its stations; it is acknowledged when that
//! transaction is on the disk, and a second attempt at the same pass changes nothing. Every change
//! is a row of a chain, each with the hash of the one before it (`audit`).
//!
//! Bottom to top: `error`, `utc`, `schema` (migrations), `database` (opened, checked, locked),
//! `row` (what is stored), `audit`, `write`, `query`, `exchange`, `prune`, `check`. A new table is
//! a migration in `schema`, its row in `row` and its line in `exchange::TABLES`.

mod audit;
mod check;
mod database;
mod error;
mod exchange;
mod prune;
mod query;
mod row;
mod schema;
mod utc;
mod write;

pub(crate) use database::Store;
pub(crate) use error::StoreError;
pub(crate) use query::StoredRow;
pub(crate) use row::{Entry, EntryKind, PassToStore, RunToStore, StationToStore};
pub(crate) use utc::Utc;
pub(crate) use write::Acknowledged;
