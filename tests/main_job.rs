//! The main job at full size, from outside the binary: the figures that docs/accuracy.md states.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

#[path = "support/program.rs"]
mod program;

#[test]
fn four_passes_of_the_slender_shaft() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let config = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/slender_shaft.toml");
    let required = std::env::var_os("REQUIRE_VULKAN").is_some_and(|v| v == "1");
    let backend = if required { "vulkan" } else { "auto" };
    let out = out.to_str().unwrap();
    let output = program::shadowgauge(["run", config, "--backend", backend, "--json", "--out", out]);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{message}");
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    if required {
        assert_eq!(json["backend"], "vulkan", "{json}");
    }
    let um = |row: &serde_json::Value, key: &str| row[key].as_f64().unwrap() * 1e3;
    let passes = json["passes"].as_array().unwrap();
    let without = json["without_control"]["passes"].as_array().unwrap();
    assert_eq!((passes.len(), without.len()), (4, 4));
    for pass in passes {
        assert!(um(pass, "worst_measured_minus_true_mm") <= 1.0, "{pass}");
        let ratio = pass["rms_error_over_u"].as_f64().unwrap();
        assert!((0.8..=1.25).contains(&ratio), "stated against actual uncertainty: {ratio} in {pass}");
    }
    for pass in &passes[1..] {
        assert!(um(pass, "true_max_abs_error_mm") <= 3.0, "{pass}");
    }
    let (with, none) = (um(&passes[3], "true_max_abs_error_mm"), um(&without[3], "true_max_abs_error_mm"));
    assert!(15.0 * with <= none, "after pass 4: {with} µm with control, {none} µm without");
    // Pass 1 is independent of the controller: both runs must have cut and measured the same part.
    assert_eq!(passes[0]["true_max_abs_error_mm"], without[0]["true_max_abs_error_mm"]);
    assert_eq!(json["in_tolerance"], true);
}

/// The stepped shaft: three sections with a tolerance each, from the bar to in tolerance.
#[test]
fn the_stepped_shaft_is_turned_in_tolerance() {
    let folder = tempfile::tempdir().unwrap();
    let config = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/stepped_shaft.toml");
    let run = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let mut arguments = vec!["run", config, "--backend", "cpu", "--json", "--out", out.to_str().unwrap()];
        arguments.extend(more);
        let output = program::shadowgauge(&arguments);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        (json, std::fs::read(out.join("stations.csv")).unwrap(), out)
    };
    let (json, stations, out) = run("run", &[]);
    let um = |row: &serde_json::Value, key: &str| row[key].as_f64().unwrap() * 1e3;
    let passes = json["passes"].as_array().unwrap();
    let without = json["without_control"]["passes"].as_array().unwrap();
    assert_eq!((passes.len(), without.len()), (3, 3));
    for pass in passes {
        assert!(um(pass, "worst_measured_minus_true_mm") <= 1.0, "{pass}");
        let ratio = pass["rms_error_over_u"].as_f64().unwrap();
        assert!((0.7..=1.4).contains(&ratio), "stated against actual uncertainty: {ratio} in {pass}");
    }
    let (with, none) = (um(&passes[2], "true_max_abs_error_mm"), um(&without[2], "true_max_abs_error_mm"));
    assert!(with <= 3.0 && 4.0 * with <= none, "after pass 3: {with} µm with control, {none} µm without");
    assert_eq!(json["in_tolerance"], true);
    let sections = json["sections"].as_array().unwrap();
    let names: Vec<&str> = sections.iter().map(|s| s["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["collar", "bearing seat A", "bearing seat B"]);
    for s in sections {
        assert_eq!((&s["judged"], &s["stations"]), (&"conforms".into(), &s["stations_measured"]), "{s}");
        assert!(um(s, "true_max_abs_error_mm") <= 3.0, "{s}");
    }
    let taper = &json["tapers"][0];
    assert!(um(taper, "measured_from_mm") - um(taper, "nominal_from_mm") < 10.0, "{taper}");
    assert!(um(taper, "max_abs_deviation_mm") < 20.0, "{taper}");
    let reasons: Vec<&str> =
        json["excluded"].as_array().unwrap().iter().map(|e| e["reason"].as_str().unwrap()).collect();
    assert_eq!(reasons, ["shoulder", "taper"]);
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("Sections") && page.contains("bearing seat B"));
    // The same bytes again, without the run beside it and on one thread.
    let (_, again, _) = run("again", &["--no-reference"]);
    assert!(stations == again, "the same config gives the same stations");
}
