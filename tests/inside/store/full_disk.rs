//! A disk that is full: nothing acknowledged is lost, nothing of the refused pass is there, and it
//! goes on when there is room.

use std::path::Path;
use std::time::Duration;

use super::killed::whole;
use super::writer::Writer;

/// Largest file, blocks: some passes, in 512 bytes or in 1024 as the shell counts.
const BLOCKS: u32 = 400;
/// A folder on a small disk, for `make store-check`.
const SMALL_DISK: &str = "SHADOWGAUGE_SMALL_DISK";

fn filled(path: &Path, limit: Option<u32>) -> String {
    let said = Writer::start(path, limit).ended();
    let refusal = said.refusal.unwrap_or_else(|| panic!("{}: never full", path.display()));
    assert!(said.acknowledged > 0, "{refusal}");
    assert_eq!(whole(path), said.acknowledged, "{refusal}");
    println!("{} passes acknowledged and there, then: {refusal}", said.acknowledged);
    refusal
}

#[test]
fn files_at_their_longest_lose_nothing_and_go_on_later() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("store.sqlite");
    let refusal = filled(&path, Some(BLOCKS));
    assert!(refusal.contains("ulimit -f") || refusal.starts_with("full "), "{refusal}");
    let before = whole(&path);
    let writer = Writer::start(&path, None);
    std::thread::sleep(Duration::from_millis(300));
    let said = writer.killed();
    let stored = whole(&path);
    assert!(said.acknowledged > before && stored >= said.acknowledged, "{before}, {stored}: {said:?}");
}

#[test]
#[ignore = "needs a small disk: make store-check"]
fn a_full_disk_is_named_and_nothing_is_lost() {
    let Some(folder) = std::env::var_os(SMALL_DISK) else {
        eprintln!("SKIPPED: {SMALL_DISK} names no folder on a small disk");
        return;
    };
    let refusal = filled(&Path::new(&folder).join("store.sqlite"), None);
    assert!(refusal.starts_with("full "), "{refusal}");
}
