//! The audit: a row a change, each with the hash of the row before it, so that a row that is
//! altered, taken out or put in later is found. What the chain alone cannot show is that its newest
//! rows were cut off: for that the last hash is noted elsewhere (`store check --head`).

use rusqlite::{Connection, OptionalExtension as _, params};
use sha2::{Digest as _, Sha256};

use super::row::Change;
use super::utc::Utc;
use crate::source::hexadecimal;

/// What the first row follows.
const BEFORE_THE_FIRST: &str = "";

/// A link as it is stored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Link {
    pub seq: i64,
    pub utc: Utc,
    pub who: String,
    pub what: String,
    pub key: String,
    pub old: Option<String>,
    pub new: Option<String>,
    pub hash: String,
}

impl Link {
    fn change(&self) -> Change<'_> {
        Change {
            utc: self.utc,
            who: &self.who,
            what: &self.what,
            key: &self.key,
            old: self.old.as_deref(),
            new: self.new.as_deref(),
        }
    }

    /// Whether its hash is that of its contents behind a row with that hash.
    pub(super) fn follows(&self, before: &str) -> bool {
        self.hash == hash(before, self.seq, &self.change())
    }
}

fn hash(before: &str, seq: i64, change: &Change<'_>) -> String {
    let mut sha = Sha256::new();
    sha.update(before);
    sha.update(seq.to_le_bytes());
    sha.update(change.utc.0.to_le_bytes());
    for text in [Some(change.who), Some(change.what), Some(change.key), change.old, change.new] {
        sha.update(text.map_or(u64::MAX, |t| t.len() as u64).to_le_bytes());
        sha.update(text.unwrap_or_default());
    }
    hexadecimal(&sha.finalize())
}

/// Number and hash of the newest row.
pub(super) fn head(db: &Connection) -> rusqlite::Result<(i64, String)> {
    let sql = "SELECT seq, hash FROM audit ORDER BY seq DESC LIMIT 1";
    let newest = db.prepare_cached(sql)?.query_row([], |row| Ok((row.get(0)?, row.get(1)?))).optional()?;
    Ok(newest.unwrap_or((0, BEFORE_THE_FIRST.to_owned())))
}

/// Adds a change to the chain.
pub(super) fn add(db: &Connection, change: &Change<'_>) -> rusqlite::Result<()> {
    let (last, before) = head(db)?;
    let seq = last + 1;
    db.prepare_cached("INSERT INTO audit VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)")?.execute(params![
        seq,
        change.utc.0,
        change.who,
        change.what,
        change.key,
        change.old,
        change.new,
        hash(&before, seq, change)
    ])?;
    Ok(())
}

/// Calls `each` with every link from the first on, and the hash of the one before it.
pub(super) fn walk(db: &Connection, mut each: impl FnMut(&Link, &str)) -> rusqlite::Result<()> {
    let mut query =
        db.prepare("SELECT seq, utc_ms, who, what, key, old, new, hash FROM audit ORDER BY seq")?;
    let mut rows = query.query([])?;
    let mut before = BEFORE_THE_FIRST.to_owned();
    while let Some(row) = rows.next()? {
        let link = Link {
            seq: row.get(0)?,
            utc: Utc(row.get(1)?),
            who: row.get(2)?,
            what: row.get(3)?,
            key: row.get(4)?,
            old: row.get(5)?,
            new: row.get(6)?,
            hash: row.get(7)?,
        };
        each(&link, &before);
        before = link.hash;
    }
    Ok(())
}
