//! Stations in, and a day of them out of ten million.

use std::path::Path;
use std::time::{Duration, Instant};

use rusqlite::Connection;

use super::{pass, run};
use crate::store::{PassToStore, Store, Utc};

const STATIONS: u32 = 1000;
const PASSES: u32 = 10_000;
const DAYS: i64 = 365;
const DAY_MS: i64 = 86_400_000;

fn long_pass(number: u32) -> PassToStore {
    let five = pass(number, 22.0).stations;
    PassToStore {
        stations: (0..STATIONS as usize).map(|k| five[k % 5].clone()).collect(),
        ..pass(number, 22.0)
    }
}

/// Stations a second, each pass acknowledged by itself.
fn passes_in(path: &Path) -> f64 {
    let mut store = Store::open(path, "Ada").unwrap();
    let from = Instant::now();
    for number in 1..=PASSES {
        store.acknowledge(&run(&format!("run {}", number / 30)), &[long_pass(number)]).unwrap();
    }
    f64::from(STATIONS * PASSES) / from.elapsed().as_secs_f64()
}

/// Frames of one station a second, 256 acknowledged together as `measure` does.
fn frames_in(path: &Path) -> f64 {
    let mut store = Store::open(path, "Ada").unwrap();
    let frame =
        |number: u32| PassToStore { stations: vec![pass(1, 22.0).stations[0].clone()], ..pass(number, 22.0) };
    let frames: Vec<PassToStore> = (1..=40 * 256).map(frame).collect();
    let from = Instant::now();
    for together in frames.chunks(256) {
        store.acknowledge(&run("frames"), together).unwrap();
    }
    frames.len() as f64 / from.elapsed().as_secs_f64()
}

/// The slowest of days all over the year, and how many stations it has.
fn day_out(path: &Path) -> (Duration, usize) {
    // what was stored within minutes is laid over a year
    let sql = "UPDATE passes SET utc_ms = (id - 1) * ?1 / ?2 * ?3";
    Connection::open(path).unwrap().execute(sql, [DAYS, i64::from(PASSES), DAY_MS]).unwrap();
    let store = Store::read(path).unwrap();
    let one = |day: i64| {
        let (from, mut all) = (Instant::now(), Vec::new());
        store.stations_between(Utc(day * DAY_MS), Utc((day + 1) * DAY_MS), |row| all.push(row)).unwrap();
        (from.elapsed(), all.len())
    };
    [3, 50, 120, 200, 280, 360].into_iter().map(one).max().unwrap()
}

#[test]
#[ignore = "minutes and a gigabyte: make store-check"]
fn twenty_thousand_stations_a_second_in_and_a_day_of_ten_million_out() {
    let folder = tempfile::tempdir().unwrap();
    let [small, path] = ["small.sqlite", "store.sqlite"].map(|name| folder.path().join(name));
    let frames = frames_in(&small);
    let rate = passes_in(&path);
    let (longest, stations) = day_out(&path);
    let bytes = std::fs::metadata(&path).unwrap().len();
    println!(
        "passes of {STATIONS} stations, each acknowledged: {rate:.0} stations/s; frames of one station, 256 together: {frames:.0}/s"
    );
    println!(
        "a day of {stations} out of {} stations ({} MB): {longest:.1?}",
        STATIONS * PASSES,
        bytes / 1_000_000
    );
    assert!(rate >= 20_000.0 && frames >= 20_000.0, "{rate} and {frames} stations/s");
    assert!(stations >= 27_000 && longest < Duration::from_millis(50), "{stations} in {longest:?}");
}
