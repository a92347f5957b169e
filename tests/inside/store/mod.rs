//! The store: every pass once, nothing altered unseen, the same rows after an export.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

mod full_disk;
mod killed;
mod speed;
mod writer;

use std::path::{Path, PathBuf};

use rusqlite::Connection;

use crate::store::{
    Acknowledged, Entry, EntryKind, PassToStore, RunToStore, StationToStore, Store, StoreError, Utc,
};

fn run(key: &str) -> RunToStore {
    RunToStore {
        key: key.into(),
        origin: "run".into(),
        name: "shaft".into(),
        part: Some("shaft".into()),
        tool: None,
        calibration: None,
        config: "seed = 1".into(),
    }
}

/// A pass of five stations, one of them a gap; values with every digit.
fn pass(number: u32, d_mm: f64) -> PassToStore {
    let station = |k: u32| StationToStore {
        z_mm: Some(10.0 * f64::from(k)),
        nominal_mm: Some(22.0),
        d_mm: (k != 3).then_some(d_mm + 1.0e-3 / 3.0 * f64::from(k)),
        u_mm: (k != 3).then_some(1e-4),
        flag: (k == 3).then(|| "no_edge".to_owned()),
    };
    PassToStore {
        pass: number,
        stations: (0..5).map(station).collect(),
        max_abs_error_mm: Some(0.01),
        decision: Some(["released".into(), String::new(), "[0.01]".into()]),
        alarm: (number == 2).then(|| "offsets beyond their limit".to_owned()),
        ..PassToStore::default()
    }
}

fn part(document: &str) -> Entry {
    Entry { kind: EntryKind::Part, key: "shaft".into(), document: document.into() }
}

/// A store with two passes of a run and a part that was changed once.
fn filled(folder: &Path) -> PathBuf {
    let path = folder.join("store.sqlite");
    let mut store = Store::open(&path, "Ada").unwrap();
    store.put(&part("{\"d\":22}")).unwrap();
    store.put(&part("{\"d\":21}")).unwrap();
    let stored = store.acknowledge(&run("a"), &[pass(1, 22.01), pass(2, 22.0)]).unwrap();
    assert_eq!(stored, [Acknowledged::Stored; 2]);
    path
}

fn findings(path: &Path, head: Option<&str>) -> Vec<String> {
    let checked = Store::read(path).unwrap().check(head).unwrap();
    checked.findings.iter().map(|f| format!("{}: {}", f.place, f.what)).collect()
}

fn alter(path: &Path, sql: &str) {
    assert!(Connection::open(path).unwrap().execute(sql, []).unwrap() > 0, "{sql}");
}

#[test]
fn a_pass_is_stored_once_and_never_with_other_values() {
    let folder = tempfile::tempdir().unwrap();
    let path = filled(folder.path());
    let mut store = Store::open(&path, "Ada").unwrap();
    let again = store.acknowledge(&run("a"), &[pass(1, 22.01), pass(2, 22.0), pass(3, 21.9)]).unwrap();
    assert_eq!(again, [Acknowledged::WasThere, Acknowledged::WasThere, Acknowledged::Stored]);
    let other = store.acknowledge(&run("a"), &[pass(4, 21.8), pass(1, 22.02)]).unwrap_err();
    assert!(matches!(other, StoreError::Contradiction { pass: 1, .. }), "{other}");
    // the pass before it in the same transaction is not there either
    let counts = store.counts().unwrap();
    assert_eq!((counts.runs, counts.passes, counts.stations), (1, 3, 15));
    assert!(findings(&path, None).is_empty());
}

#[test]
fn values_come_back_to_the_last_digit() {
    let folder = tempfile::tempdir().unwrap();
    let path = filled(folder.path());
    let mut rows = Vec::new();
    let store = Store::read(&path).unwrap();
    store.stations_between(Utc(0), Utc(i64::MAX), |row| rows.push(row.station)).unwrap();
    let expected: Vec<_> = [pass(1, 22.01), pass(2, 22.0)].into_iter().flat_map(|p| p.stations).collect();
    assert_eq!(rows, expected);
    store.stations_between(Utc(0), Utc(1), |row| panic!("{row:?} was stored in 1970")).unwrap();
}

#[test]
fn whatever_is_altered_is_found_and_named() {
    let cases = [
        ("UPDATE audit SET who = 'Eve' WHERE seq = 2", "audit row 2"),
        ("UPDATE audit SET new = '{}' WHERE seq = 1", "audit row 1"),
        ("DELETE FROM audit WHERE seq = 3", "rows 3 to 3 are missing"),
        ("UPDATE stations SET d_mm = d_mm + 1e-9 WHERE pass = 2 AND station = 1", "pass a/2"),
        ("DELETE FROM stations WHERE pass = 1 AND station = 4", "pass a/1"),
        ("UPDATE runs SET config = 'seed = 2'", "run a"),
        ("UPDATE decisions SET decision = 'held' WHERE pass = 1", "pass a/1"),
        ("UPDATE decisions SET offsets_mm = '[0.02]' WHERE pass = 2", "pass a/2"),
        ("DELETE FROM alarms", "pass a/2"),
        ("UPDATE passes SET max_abs_error_mm = 0.001 WHERE id = 1", "pass a/1"),
        ("UPDATE entries SET document = '{\"d\":20}'", "part shaft"),
    ];
    for (sql, place) in cases {
        let folder = tempfile::tempdir().unwrap();
        let path = filled(folder.path());
        alter(&path, sql);
        let found = findings(&path, None);
        assert!(found.iter().any(|f| f.contains(place)), "{sql}: {found:?}");
    }
}

#[test]
fn rows_that_were_cut_off_are_found_by_a_noted_head() {
    let folder = tempfile::tempdir().unwrap();
    let path = filled(folder.path());
    let head = Store::read(&path).unwrap().check(None).unwrap().head;
    let mut store = Store::open(&path, "Ada").unwrap();
    store.acknowledge(&run("b"), &[pass(1, 22.0)]).unwrap();
    assert!(findings(&path, Some(&head)).is_empty(), "later rows are no fault");
    for sql in ["DELETE FROM audit WHERE seq > 2", "DELETE FROM decisions", "DELETE FROM alarms"] {
        alter(&path, sql);
    }
    for sql in ["DELETE FROM stations", "DELETE FROM passes", "DELETE FROM runs"] {
        alter(&path, sql);
    }
    assert!(findings(&path, None).is_empty(), "the chain alone cannot show it");
    assert!(findings(&path, Some(&head))[0].contains("cut off"), "{:?}", findings(&path, Some(&head)));
}

#[test]
fn an_export_read_into_a_new_store_is_the_same_store() {
    let folder = tempfile::tempdir().unwrap();
    let path = filled(folder.path());
    let mut lines = Vec::new();
    Store::open(&path, "Ada").unwrap().export(&mut lines).unwrap();
    let copy = folder.path().join("copy.sqlite");
    let mut store = Store::open(&copy, "Bob").unwrap();
    store.import(&mut lines.as_slice(), Path::new("export.jsonl")).unwrap();
    let (a, b) = (Store::read(&path).unwrap().check(None).unwrap(), store.check(None).unwrap());
    assert_eq!(a, b);
    assert!(b.findings.is_empty());
    let mut again = Vec::new();
    store.export(&mut again).unwrap();
    assert_eq!(lines, again);
}

#[test]
fn what_is_no_export_is_refused_with_its_line_and_nothing_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let header = "{\"shadowgauge_store\":1}\n";
    let row =
        "{\"table\":\"entries\",\"row\":{\"kind\":\"part\",\"key\":\"p\",\"utc_ms\":1,\"document\":\"\"}}\n";
    let cases = [
        ("pass,z_mm\n".to_owned(), "line 1"),
        (format!("{header}{row}{{\"table\":\"parts\",\"row\":{{}}}}\n"), "line 3"),
        (format!("{header}{row}{{\"table\":\"runs\",\"row\":{{\"colour\":1}}}}\n"), "colour"),
        ("{\"shadowgauge_store\":9}\n".to_owned(), "schema 9"),
        (header.to_owned(), "no row"),
    ];
    for (k, (text, words)) in cases.iter().enumerate() {
        let mut store = Store::open(&folder.path().join(format!("{k}.sqlite")), "Ada").unwrap();
        let refused = store.import(&mut text.as_bytes(), Path::new("export.jsonl")).unwrap_err().to_string();
        assert!(refused.contains(words), "{refused}");
        assert_eq!(store.check(None).unwrap().audit_rows, 0);
    }
}

#[test]
fn what_was_pruned_is_no_finding_and_stays_in_the_audit() {
    let folder = tempfile::tempdir().unwrap();
    let path = filled(folder.path());
    let mut store = Store::open(&path, "Ada").unwrap();
    assert_eq!(store.prune(Utc(1)).unwrap(), 0);
    assert_eq!(store.prune(Utc(Utc::now().0 + 1000)).unwrap(), 2);
    let counts = store.counts().unwrap();
    assert_eq!((counts.runs, counts.passes, counts.stations), (0, 0, 0));
    let checked = store.check(None).unwrap();
    assert!(checked.findings.is_empty(), "{:?}", checked.findings);
    assert_eq!(checked.audit_rows, 7);
}

#[test]
fn other_files_and_newer_stores_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let absent = Store::read(&folder.path().join("absent.sqlite")).unwrap_err().to_string();
    assert!(absent.contains("no such file") && !absent.contains("an absent file"), "{absent}");
    let text = folder.path().join("notes.txt");
    std::fs::write(&text, "no database at all, only a text of some length".repeat(30)).unwrap();
    let other = folder.path().join("other.sqlite");
    alter_new(&other, "CREATE TABLE mine (x); INSERT INTO mine VALUES (1)");
    let newer = filled(folder.path());
    alter_new(&newer, "PRAGMA user_version = 9");
    for (path, words) in [(&text, "no SQLite"), (&other, "another program"), (&newer, "schema 9")] {
        let before = std::fs::read(path).unwrap();
        let refused = Store::open(path, "Ada").unwrap_err();
        assert!(refused.to_string().contains(words) && refused.is_refusal(), "{refused}");
        assert!(path == &newer || std::fs::read(path).unwrap() == before, "{} was altered", path.display());
    }
    assert!(Store::read(&folder.path().join("absent.sqlite")).is_err());
}

fn alter_new(path: &Path, sql: &str) {
    Connection::open(path).unwrap().execute_batch(sql).unwrap();
}
