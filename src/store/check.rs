//! Whether a store is what was written into it: the file itself, the chain of the audit, and every
//! table against what the audit has of it.

use std::collections::HashMap;

use rusqlite::Connection;
use serde::Serialize;

use super::audit::{self, Link};
use super::database::Store;
use super::error::StoreError;
use super::prune::PRUNE;
use super::row::{PassToStore, RunToStore, StationToStore};
use super::utc::Utc;
use super::write::{pass_key, pass_text, run_text};

/// Something that does not fit together.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct Finding {
    /// Where: a table and a key, or a row of the audit.
    pub place: String,
    /// What is wrong.
    pub what: String,
}

/// What a check has found, and the hash of the newest row of the audit.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct Checked {
    /// Rows of the audit.
    pub audit_rows: i64,
    /// Hash of the newest one: noted elsewhere, it shows later that no rows were cut off.
    pub head: String,
    /// What is wrong; empty where nothing is.
    pub findings: Vec<Finding>,
}

/// The newest state of every key by the audit.
#[derive(Default)]
struct ByAudit {
    /// Newest contents by (what, key), with the time of the change.
    newest: HashMap<(String, String), (Utc, String)>,
    /// Passes before this instant were pruned.
    pruned_before: Option<Utc>,
    hashes: Vec<String>,
}

impl Store {
    /// Checks everything. `noted` is the hash of an earlier newest row, which must still be there.
    ///
    /// # Errors
    /// A store that cannot be read.
    pub(crate) fn check(&self, noted: Option<&str>) -> Result<Checked, StoreError> {
        let read = || {
            let mut findings = integrity(&self.db)?;
            let state = chain(&self.db, &mut findings)?;
            if let Some(noted) = noted.filter(|noted| !state.hashes.iter().any(|hash| hash == noted)) {
                let what = format!("no row has the hash {noted}: rows were cut off or written anew");
                findings.push(Finding { place: "audit".into(), what });
            }
            let there = stored(&self.db)?;
            findings.extend(compared(&state, &there));
            let (audit_rows, head) = audit::head(&self.db)?;
            Ok(Checked { audit_rows, head, findings })
        };
        read().map_err(|e: rusqlite::Error| self.failure(&e))
    }
}

fn integrity(db: &Connection) -> rusqlite::Result<Vec<Finding>> {
    let mut query = db.prepare("PRAGMA integrity_check")?;
    let words = query.query_map([], |row| row.get::<_, String>(0))?;
    let bad = |word: rusqlite::Result<String>| match word {
        Ok(word) if word == "ok" => None,
        Ok(what) => Some(Ok(Finding { place: "file".into(), what })),
        Err(error) => Some(Err(error)),
    };
    words.filter_map(bad).collect()
}

/// Walks the chain; every row that does not follow the one before it is a finding.
fn chain(db: &Connection, findings: &mut Vec<Finding>) -> rusqlite::Result<ByAudit> {
    let mut state = ByAudit::default();
    let mut expected = 1;
    audit::walk(db, |link, before| {
        let place = || format!("audit row {} of {} by {:?}", link.seq, link.utc, link.who);
        if link.seq != expected {
            let what = format!("rows {expected} to {} are missing before it", link.seq - 1);
            findings.push(Finding { place: place(), what });
        } else if !link.follows(before) {
            let what = format!("{} {} was altered, or the row before it", link.what, link.key);
            findings.push(Finding { place: place(), what });
        }
        expected = link.seq + 1;
        state.take(link);
    })?;
    Ok(state)
}

impl ByAudit {
    fn take(&mut self, link: &Link) {
        self.hashes.push(link.hash.clone());
        if link.what == PRUNE {
            let before = link.key.parse().map_or(Utc(i64::MIN), Utc);
            self.pruned_before = Some(self.pruned_before.map_or(before, |b| b.max(before)));
        } else if let Some(new) = &link.new {
            self.newest.insert((link.what.clone(), link.key.clone()), (link.utc, new.clone()));
        } else {
            // taken out by an audited change
            self.newest.remove(&(link.what.clone(), link.key.clone()));
        }
    }

    /// Whether a row may be absent since it was pruned.
    fn may_be_absent(&self, what: &str, utc: Utc) -> bool {
        matches!(what, "pass" | "run") && self.pruned_before.is_some_and(|before| utc < before)
    }
}

/// Contents of the tables by (what, key), as the audit has them.
fn stored(db: &Connection) -> rusqlite::Result<HashMap<(String, String), String>> {
    let mut all = HashMap::new();
    let mut query = db.prepare("SELECT kind, key, document FROM entries")?;
    for row in query.query_map([], |row| Ok(((row.get(0)?, row.get(1)?), row.get(2)?)))? {
        let (key, document) = row?;
        all.insert(key, document);
    }
    let mut query = db.prepare("SELECT key, origin, name, part, tool, calibration, config FROM runs")?;
    let runs = query.query_map([], |row| {
        Ok(RunToStore {
            key: row.get(0)?,
            origin: row.get(1)?,
            name: row.get(2)?,
            part: row.get(3)?,
            tool: row.get(4)?,
            calibration: row.get(5)?,
            config: row.get(6)?,
        })
    })?;
    for run in runs {
        let run = run?;
        all.insert(("run".to_owned(), run.key.clone()), run_text(&run));
    }
    passes(db, &mut all)?;
    Ok(all)
}

/// Every pass with the digest of what is there of it.
fn passes(db: &Connection, all: &mut HashMap<(String, String), String>) -> rusqlite::Result<()> {
    let mut query = db.prepare(
        "SELECT p.id, r.key, p.pass, p.name, p.max_abs_error_mm, d.decision, d.reason, d.offsets_mm, a.words \
         FROM passes p JOIN runs r ON r.id = p.run LEFT JOIN decisions d ON d.pass = p.id \
         LEFT JOIN alarms a ON a.pass = p.id",
    )?;
    let mut rows = query.query([])?;
    while let Some(row) = rows.next()? {
        let (id, run): (i64, String) = (row.get(0)?, row.get(1)?);
        let decision: [Option<String>; 3] = [row.get(5)?, row.get(6)?, row.get(7)?];
        let pass = PassToStore {
            pass: row.get(2)?,
            name: row.get(3)?,
            stations: stations(db, id)?,
            max_abs_error_mm: row.get(4)?,
            decision: match decision {
                [Some(word), Some(reason), Some(offsets)] => Some([word, reason, offsets]),
                _ => None,
            },
            alarm: row.get(8)?,
        };
        let key = ("pass".to_owned(), pass_key(&run, pass.pass));
        all.insert(key, pass_text(&pass.digest(), pass.stations.len()));
    }
    Ok(())
}

fn stations(db: &Connection, pass: i64) -> rusqlite::Result<Vec<StationToStore>> {
    let sql = "SELECT z_mm, nominal_mm, d_mm, u_mm, flag FROM stations WHERE pass = ?1 ORDER BY station";
    let mut query = db.prepare_cached(sql)?;
    let rows = query.query_map([pass], |row| {
        Ok(StationToStore {
            z_mm: row.get(0)?,
            nominal_mm: row.get(1)?,
            d_mm: row.get(2)?,
            u_mm: row.get(3)?,
            flag: row.get(4)?,
        })
    })?;
    rows.collect()
}

fn compared(state: &ByAudit, there: &HashMap<(String, String), String>) -> Vec<Finding> {
    let mut findings = Vec::new();
    for ((what, key), (utc, by_audit)) in &state.newest {
        let wrong = match there.get(&(what.clone(), key.clone())) {
            Some(contents) if contents == by_audit => continue,
            Some(_) => "differs from what was stored",
            None if state.may_be_absent(what, *utc) => continue,
            None => "was taken out, and no prune says so",
        };
        findings.push(Finding { place: format!("{what} {key} of {utc}"), what: wrong.into() });
    }
    for (what, key) in there.keys().filter(|&key| !state.newest.contains_key(key)) {
        let wrong = "stands in its table, and no row of the audit says so".to_owned();
        findings.push(Finding { place: format!("{what} {key}"), what: wrong });
    }
    findings.sort_by(|a, b| a.place.cmp(&b.place));
    findings
}
