//! Graphics adapters of other machines: the choice among them, clean exits, and no messages of the
//! drivers to the user.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// A small job in `folder`.
fn config(folder: &Path) -> PathBuf {
    let path = folder.join("job.toml");
    std::fs::write(&path, include_str!("../../support/small_render_job.toml")).unwrap();
    path
}

fn render(config: &Path, out: &Path, backend: &str) -> Output {
    Command::new(crate::inside::support::program::path())
        .arg("render")
        .arg(config)
        .args(["--frames", "1", "--backend", backend, "--out"])
        .arg(out)
        .env_remove("XDG_RUNTIME_DIR")
        .output()
        .expect("the program runs")
}

/// Whether this machine offers the interface; prints a notice where it does not and
/// `REQUIRE_VULKAN` is not set.
fn is_offered(config: &Path, out: &Path, backend: &str) -> bool {
    let output = render(config, out, backend);
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.code() == Some(3) && words.contains("adapter") {
        let required = backend == "vulkan" && std::env::var("REQUIRE_VULKAN").as_deref() == Ok("1");
        assert!(!required, "REQUIRE_VULKAN=1: {words}");
        eprintln!("SKIPPED: no {backend} adapter here");
        return false;
    }
    true
}

/// Double frees at exit ended one run in 200 while OpenGL and Vulkan were opened together: every
/// exit is clean, the frames are the same bytes on every backend, and stderr is empty even without
/// XDG_RUNTIME_DIR.
#[test]
fn renders_end_cleanly_and_quietly_on_every_backend() {
    let folder = tempfile::tempdir().unwrap();
    let config = config(folder.path());
    let mut first: Option<Vec<u8>> = None;
    for (backend, runs) in [("cpu", 5), ("auto", 20), ("vulkan", 20), ("gl", 5)] {
        if !is_offered(&config, &folder.path().join(format!("{backend}_probe")), backend) {
            continue;
        }
        for index in 0..runs {
            let out = folder.path().join(format!("{backend}_{index}"));
            let output = render(&config, &out, backend);
            let words = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(0), "{backend}, run {index}: {:?} {words}", output.status);
            assert_eq!(words, "", "{backend}, run {index}");
            let frame = std::fs::read(out.join("frames/000000.png")).unwrap();
            assert_eq!(first.get_or_insert_with(|| frame.clone()), &frame, "{backend}, run {index}");
        }
    }
}

/// `auto` chooses the adapter named by `doctor`, never a software adapter.
#[test]
fn auto_takes_what_doctor_names_and_no_software() {
    let output = super::support::shadowgauge(["doctor", "--json"]);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let auto = found["auto"]["adapter"].as_str().unwrap();
    let kinds: Vec<&str> = found["adapters"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|a| a["name"] == auto)
        .map(|a| a["kind"].as_str().unwrap())
        .collect();
    assert!(!kinds.contains(&"cpu"), "{found}");
    assert!(kinds.len() == 1 || found["auto"]["backend"] == "cpu", "{found}");
    let folder = tempfile::tempdir().unwrap();
    let output = render(&config(folder.path()), &folder.path().join("out"), "auto");
    assert!(String::from_utf8_lossy(&output.stdout).contains(auto), "{output:?}");
}

/// The check of an adapter: equal to the twin on a software adapter requested by name; without
/// hardware, exit code 3 with a message.
#[test]
fn an_adapter_is_checked_against_the_twin() {
    let run = |backend: &str| {
        super::support::shadowgauge([
            "doctor",
            "--gpu-check",
            "--json",
            "--frames",
            "1",
            "--backend",
            backend,
        ])
    };
    let output = run("vulkan");
    let words = String::from_utf8_lossy(&output.stderr);
    if output.status.code() == Some(3) {
        assert!(std::env::var("REQUIRE_VULKAN").as_deref() != Ok("1"), "{words}");
        eprintln!("SKIPPED: no Vulkan adapter here: {words}");
        return;
    }
    assert_eq!(output.status.code(), Some(0), "{words}");
    let check: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(check["cases"].as_array().unwrap().len(), 14);
    assert!(check["cases"].as_array().unwrap().iter().all(|c| c["agrees"] == true), "{check}");
    assert!(check["times"][0]["adapter_ms"].as_f64().unwrap() > 0.0);
    let output = super::support::shadowgauge(["doctor", "--json"]);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    if found["auto"]["backend"] == "cpu" {
        let output = run("auto");
        assert_eq!(output.status.code(), Some(3));
        assert!(
            String::from_utf8_lossy(&output.stderr).contains("no hardware graphics adapter"),
            "{output:?}"
        );
    }
}
