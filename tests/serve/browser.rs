//! Flows of a person in a headless Chromium (`scripts/pages`); SKIPPED, loudly, where that or Node
//! is missing. All pages at all widths, with axe-core, are checked by `make pages-check`.

use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};

use super::small_job::ONE_PASS;
use super::{Server, text};

/// Chromium under one of its names, where Node is there too.
fn chromium() -> Option<&'static str> {
    let answers =
        |program: &str| Command::new(program).arg("--version").output().is_ok_and(|o| o.status.success());
    let names = ["chromium", "chromium-browser", "google-chrome"];
    names.into_iter().find(|name| answers("node") && answers(name))
}

/// Drives a flow; what it printed, or none without a browser.
fn driven(flow: &str, server: &Server, folder: &Path, work: &Value) -> Option<String> {
    let Some(chromium) = chromium() else {
        eprintln!(
            "SKIPPED: {flow} is not driven in a browser: no Chromium or no Node (apt-get install chromium nodejs)"
        );
        return None;
    };
    let file = folder.join("work.json");
    std::fs::write(&file, work.to_string()).unwrap();
    let url = format!("http://{}/", server.host);
    let script = ["scripts/pages/check.mjs", "flow", flow, &url, chromium, text(&file)];
    let done = Command::new("node").args(script).output().unwrap();
    let said = format!("{}{}", String::from_utf8_lossy(&done.stdout), String::from_utf8_lossy(&done.stderr));
    assert!(done.status.success(), "{said}");
    Some(said)
}

#[test]
fn an_outline_a_tool_and_a_machine_become_a_program_in_a_browser() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("store.sqlite");
    let server = Server::start(&["--store", text(&store)]);
    let work = json!({ "modes": ["compensated", "batch"] });
    let Some(said) = driven("program", &server, folder.path(), &work) else { return };
    assert_eq!(said.matches("of the line drawn").count(), 2, "{said}");
    assert_eq!(server.get("/api/programs").json()["total"], 2);
}

#[test]
fn a_run_is_started_watched_and_reported_in_a_browser() {
    let folder = tempfile::tempdir().unwrap();
    let (store, job) = (folder.path().join("store.sqlite"), folder.path().join("job.toml"));
    std::fs::write(&job, ONE_PASS).unwrap();
    let runs = folder.path().join("runs");
    std::fs::create_dir(&runs).unwrap();
    let server = Server::start(&["--runs", text(&runs), "--store", text(&store)]);
    driven("run", &server, folder.path(), &json!({ "job": text(&job) }));
}

#[test]
fn a_setup_is_calibrated_and_stands_in_the_history_in_a_browser() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("store.sqlite");
    let server = Server::start(&["--store", text(&store)]);
    if driven("calibrate", &server, folder.path(), &json!({})).is_none() {
        return;
    }
    let all = server.get("/api/calibrations").json();
    assert_eq!(all.as_array().unwrap().len(), 1, "{all}");
    assert_eq!(all[0]["check"]["accepted"], true, "{all}");
}
