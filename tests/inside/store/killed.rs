//! Killed at any instant: every acknowledged pass is there, once.

use std::path::Path;
use std::time::Duration;

use rusqlite::Connection;

use super::findings;
use super::writer::Writer;
use crate::store::Store;

/// Stations of a pass of the writer.
const STATIONS: i64 = 5;

/// Passes of a store, none twice and none missing between.
pub(super) fn whole(path: &Path) -> i64 {
    if !path.is_file() || std::fs::metadata(path).unwrap().len() == 0 {
        return 0;
    }
    // as a process that goes on: this one may have to make the store's tables
    let counts = Store::open(path, "reader").unwrap().counts().unwrap();
    let sql = "SELECT ifnull(max(pass), 0), count(DISTINCT pass) FROM passes";
    let (newest, different): (i64, i64) =
        Connection::open(path).unwrap().query_row(sql, [], |row| Ok((row.get(0)?, row.get(1)?))).unwrap();
    assert_eq!((counts.passes, counts.stations), (newest, STATIONS * newest));
    assert_eq!(different, newest);
    assert!(findings(path, None).is_empty(), "{:?}", findings(path, None));
    counts.passes
}

/// Kills a writer of one store again and again, at instants between its start and some hundred
/// passes.
fn killed(times: u32) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("store.sqlite");
    let (mut acknowledged, mut state, mut amid) = (0, 1_u32, 0);
    for k in 0..times {
        let writer = Writer::start(&path, None);
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        std::thread::sleep(Duration::from_millis(u64::from(10 + (state >> 16) % 200)));
        let said = writer.killed();
        assert!(said.refusal.is_none(), "kill {k}: {said:?}");
        amid += u32::from(said.acknowledged > acknowledged);
        acknowledged = acknowledged.max(said.acknowledged);
        let stored = whole(&path);
        // one more was on the disk, perhaps, before it could be said
        assert!((acknowledged..=acknowledged + 1).contains(&stored), "kill {k}: {stored} of {acknowledged}");
        acknowledged = stored;
    }
    println!(
        "killed {times} times, {amid} of them amid passes: {acknowledged} passes, none lost, none twice"
    );
    assert!(amid > times / 4, "only {amid} of {times} writers had written");
}

#[test]
fn what_was_acknowledged_before_a_kill_is_there_once() {
    killed(6);
}

#[test]
#[ignore = "a minute: make store-check"]
fn a_hundred_kills_lose_nothing() {
    killed(100);
}
