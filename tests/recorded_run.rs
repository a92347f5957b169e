//! Runs on recorded frames, from outside: what a simulated run recorded gives the same diameters
//! and offsets; a pass that is missing is waited for; sources of other kinds are refused.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

#[path = "support/program.rs"]
mod program;
#[path = "support/small_job.rs"]
mod small_job;

use program::{json, said, shadowgauge};
use small_job::TWO_PASSES as JOB;
use std::path::Path;
use std::process::Output;

/// Runs a job in a folder.
fn run(folder: &Path, job: &str, out: &str, more: &[&str]) -> Output {
    let config = folder.join(format!("{out}.toml"));
    std::fs::write(&config, job).unwrap();
    let (config, out) = (config.to_string_lossy().into_owned(), folder.join(out));
    let fixed =
        ["run", &config, "--out", &out.to_string_lossy(), "--backend", "cpu", "--no-reference", "--json"];
    shadowgauge([&fixed[..], more].concat())
}

/// Columns of a table by name, row by row.
fn columns(folder: &Path, table: &str, names: &[&str]) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_path(folder.join(table)).unwrap();
    let header = reader.headers().unwrap().clone();
    let places: Vec<usize> =
        names.iter().map(|name| header.iter().position(|h| h == *name).unwrap()).collect();
    let row = |r: csv::StringRecord| places.iter().map(|&i| r[i].to_owned()).collect();
    reader.records().map(|r| row(r.unwrap())).collect()
}

const MEASURED: [&str; 5] = ["pass", "z_mm", "d_mm", "u_random_mm", "u_common_mm"];
const OFFSETS: [&str; 4] = ["pass", "z_mm", "offset_mm", "commanded_mm"];

#[test]
fn recorded_frames_give_what_the_simulated_run_gave_and_a_missing_pass_is_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let record = folder.join("frames").to_string_lossy().into_owned();
    let simulated = run(folder, JOB, "simulated", &["--record", &record]);
    assert!(matches!(simulated.status.code(), Some(0 | 1)), "{}", said(&simulated));
    for name in [
        "masters/pin_1/000001.png",
        "masters/pin_2/frames.csv",
        "pass_1/000019.png",
        "pass_2/master/000000.png",
    ] {
        assert!(folder.join("frames").join(name).is_file(), "{name}");
    }

    // the second pass is not cut yet
    let away = folder.join("pass_2");
    std::fs::rename(folder.join("frames/pass_2"), &away).unwrap();
    let job = format!("source = \"frames\"\n{JOB}");
    let waiting = run(folder, &job, "recorded", &[]);
    assert_eq!(waiting.status.code(), Some(0), "{}", said(&waiting));
    let document = json(&waiting);
    assert_eq!(
        (document["backend"].as_str(), document["waits_for"]["pass"].as_u64()),
        (Some("recorded"), Some(2))
    );
    let pass = document["passes"][0].as_object().unwrap();
    assert!(!pass.keys().any(|key| key.starts_with("true_") || key.contains("minus_true")), "{pass:?}");
    let (own, theirs) = (folder.join("recorded"), folder.join("simulated"));
    assert!(!own.join("report.html").exists() && !own.join("truth.parquet").exists());
    assert_eq!(columns(&own, "offsets.csv", &OFFSETS), columns(&theirs, "offsets.csv", &OFFSETS));
    let program = shadowgauge(["nc", &own.to_string_lossy(), "--dialect", "linuxcnc"]);
    assert_eq!(program.status.code(), Some(0), "{}", said(&program));

    // the same command goes on
    std::fs::rename(&away, folder.join("frames/pass_2")).unwrap();
    let done = run(folder, &job, "recorded", &[]);
    assert_eq!(done.status.code(), simulated.status.code(), "{}", said(&done));
    assert_eq!(columns(&own, "stations.csv", &MEASURED), columns(&theirs, "stations.csv", &MEASURED));
    assert_eq!(columns(&own, "offsets.csv", &OFFSETS), columns(&theirs, "offsets.csv", &OFFSETS));
    assert_eq!(json(&done)["conformity"], json(&simulated)["conformity"]);
    let page = std::fs::read_to_string(own.join("report.html")).unwrap();
    assert!(
        page.contains("the truth of a real part is not given") && !page.contains("(error/u)"),
        "truth in the report"
    );

    // a copy of the first pass is no second pass
    std::fs::remove_dir_all(folder.join("frames/pass_2")).unwrap();
    std::fs::create_dir(folder.join("frames/pass_2")).unwrap();
    for entry in std::fs::read_dir(folder.join("frames/pass_1")).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            std::fs::copy(&path, folder.join("frames/pass_2").join(path.file_name().unwrap())).unwrap();
        }
    }
    let copied = run(folder, &job, "copied", &[]);
    assert_eq!(copied.status.code(), Some(3), "{}", said(&copied));
    assert!(said(&copied).contains("the same image"), "{}", said(&copied));
    the_check_pin_reaches_the_guard(folder);
}

/// A check pin that has drifted holds the run: `frames` in the folder has a recorded first pass.
fn the_check_pin_reaches_the_guard(folder: &Path) {
    let first_pass = |out: &str| {
        let text = std::fs::read_to_string(folder.join(out).join("control.json")).unwrap();
        let document: serde_json::Value = serde_json::from_str(&text).unwrap();
        document["passes"][0].clone()
    };
    let deviation_mm = |pass: &serde_json::Value| pass["evidence"]["origin"]["master_deviation_mm"].as_f64();
    let good = first_pass("recorded");
    let reason = good["reason"].as_str().unwrap_or_default();
    assert!(deviation_mm(&good).unwrap().abs() < 0.002 && !reason.contains("calibrate the gauge"), "{good}");
    // a head whose magnification is 1000 ppm larger: 10 µm of the first pin, limit 2 µm
    let warm = JOB.replace("magnification = 0.115", "magnification = 0.115115");
    let record = folder.join("warm").to_string_lossy().into_owned();
    let output = run(folder, &warm, "warmed", &["--record", &record, "--passes", "1"]);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", said(&output));
    let pin = "pass_1/master/000000.png";
    std::fs::copy(folder.join("warm").join(pin), folder.join("frames").join(pin)).unwrap();
    std::fs::remove_dir_all(folder.join("frames/pass_2")).unwrap();
    let held = run(folder, &format!("source = \"frames\"\n{JOB}"), "held", &[]);
    let pass = first_pass("held");
    assert!((deviation_mm(&pass).unwrap() - 0.010).abs() < 0.002, "{pass} {}", said(&held));
    assert_eq!(pass["decision"], "held", "{pass}");
    assert!(pass["reason"].as_str().unwrap().contains("calibrate the gauge"), "{pass}");
}

#[test]
fn sources_that_are_none_are_refused_by_their_names() {
    let folder = tempfile::tempdir().unwrap();
    for (source, word) in [
        ("gige:", "IP address"),
        ("sim:job.toml", "simulated camera"),
        ("nowhere", "nowhere"),
        ("-", "pass by pass"),
    ] {
        let output = run(folder.path(), &format!("source = \"{source}\"\n{JOB}"), "refused", &[]);
        assert_eq!(output.status.code(), Some(2), "{source}: {}", said(&output));
        assert!(
            said(&output).contains("source") && said(&output).contains(word),
            "{source}: {}",
            said(&output)
        );
        assert!(!folder.path().join("refused").exists(), "{source}: something was written");
    }
}
