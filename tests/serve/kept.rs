//! What a person stops and starts again: runs that are resumed, recordings that are watched.

use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::{Value, json};

use super::program;
use super::small_job::{FIVE_PASSES, TWO_PASSES};
use super::{Server, text};

/// A run is stopped after its first pass and resumed: every pass is in its folder and in the store
/// once, and the report is there.
#[test]
fn a_run_that_is_stopped_keeps_its_passes_and_is_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("store.sqlite");
    let server = Server::start(&["--runs", text(folder.path()), "--store", text(&store)]);
    let started = server.post("/api/runs", &json!({ "run": "part", "config": FIVE_PASSES }));
    assert_eq!(started.status, 202, "{}", started.body);
    server.once("/api/jobs/part", |job| job["passes"].as_u64() >= Some(1));
    assert_eq!(server.post("/api/runs/part/stop", &json!({})).status, 202);
    let stopped = server.once("/api/jobs/part", |job| job["running"] == false);
    let kept = stopped["passes"].as_u64().unwrap();
    assert!((1..5).contains(&kept), "stopped amid its passes: {stopped}");
    assert_eq!(server.get("/api/runs/part").json()["passes"].as_array().map(Vec::len), Some(kept as usize));
    assert_eq!(server.get("/api/runs?name=part").json()["runs"][0]["finished"], false);
    assert_eq!(server.post("/api/runs/part/stop", &json!({})).status, 409, "it does not run any more");
    let resumed = server.post("/api/runs/part/resume", &json!({}));
    assert_eq!(resumed.status, 202, "{}", resumed.body);
    let ended = server.once("/api/jobs/part", |job| job["running"] == false && job["passes"] == 5);
    assert_eq!(ended["exit"], 0, "{ended}");
    assert_eq!(server.get("/api/runs/part/report").status, 200);
    let state = server.get("/api/store").json();
    assert_eq!((&state["findings"], &state["passes"]), (&json!([]), &json!(5)));
    assert_eq!(server.post("/api/runs/part/resume", &json!({})).status, 409, "it is finished");
}

/// The simulated head as a recording, with a frame of it as it was measured meanwhile.
fn recorded(folder: &Path) -> (String, Value) {
    let (config, file) = (folder.join("head.toml"), folder.join("head.mcap"));
    std::fs::write(&config, TWO_PASSES).unwrap();
    let source = format!("sim:{}", text(&config));
    let mut watch = Command::new(program::path())
        .args(["watch", &source, "--um-per-px", "50", "--json", "--record", text(&file)])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(watch.stdout.take().unwrap()).lines().map_while(Result::ok);
    let mut frames = lines.filter_map(|line| serde_json::from_str::<Value>(&line).ok());
    let frame = frames.by_ref().find(|v| v["valid"] == true).expect("no frame with a diameter came");
    assert_eq!(frames.take(8).count(), 8);
    let id = watch.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    assert!(watch.wait().unwrap().success());
    (format!("replay:{}", text(&file)), frame)
}

/// A recording is watched as a camera is: its diameters are those of the frames, and once it has
/// ended the page reads invalid.
#[test]
fn a_recording_is_watched_and_reads_invalid_once_it_has_ended() {
    let folder = tempfile::tempdir().unwrap();
    let (source, recorded) = recorded(folder.path());
    let server = Server::start(&["--source", &source, "--", "--um-per-px", "50"]);
    let mut events = server.events("/api/live");
    let is_it = |v: &Value| v["sequence"] == recorded["sequence"] && v["valid"] == true;
    let frame = events.find(is_it).expect("the recorded frame did not come");
    assert_eq!(frame["max_diameter_mm"], recorded["max_diameter_mm"]);
    events.find(|v| v["event"] == "invalid").expect("a recording that has ended reads invalid");
}
