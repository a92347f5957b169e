//! `run` and `demo` from outside the binary: exit codes, messages, folders, resume.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

#[path = "support/program.rs"]
mod program;

use program::{json, said, shadowgauge, text};
use std::path::Path;
use std::process::{Command, Output};

/// A job small enough to run in a second: a short part, two passes, a small camera.
const SMALL: &str = concat!(
    r#"
name = "small"
seed = 5
[part]
length_mm = 60.0
stock_diameter_mm = 12.0
nominal_diameter_mm = [11.5, 11.0]
aim_mm = 0.0
[part.tolerance]
nominal_mm = 11.0
upper_mm = 0.01
lower_mm = -0.01
"#,
    include_str!("support/small_view.toml")
);

fn write(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path.to_string_lossy().into_owned()
}

fn run_small(folder: &Path, out: &str, more: &[&str]) -> Output {
    let config = write(folder, "small.toml", SMALL);
    let out = folder.join(out).to_string_lossy().into_owned();
    shadowgauge([&["run", &config, "--out", &out, "--backend", "cpu"], more].concat())
}

fn stderr(output: &Output) -> String {
    text(&output.stderr)
}

/// (changed key, new value, exit code, words in the error)
#[test]
fn a_wrong_config_is_one_clear_error_and_leaves_nothing_behind() {
    let cases: [(&str, String, i32, &[&str]); 11] = [
        ("unknown key", SMALL.replace("length_mm", "lenght_mm"), 2, &["lenght_mm", "length_mm"]),
        ("wrong unit", SMALL.replace("length_mm = 60.0", "length_cm = 6.0"), 2, &["length_cm", "length_mm"]),
        (
            "wrong type",
            SMALL.replace("length_mm = 60.0", "length_mm = \"60 mm\""),
            2,
            &["60 mm", "length_mm = 60`"],
        ),
        (
            "shaft larger than the field",
            SMALL.replace("= 12.0", "= 120.0"),
            2,
            &["part.stock_diameter_mm", "field"],
        ),
        ("magnification zero", SMALL.replace("= 0.115", "= 0.0"), 2, &["optics.magnification"]),
        (
            "diameters that rise",
            SMALL.replace("[11.5, 11.0]", "[11.0, 11.5]"),
            2,
            &["part.nominal_diameter_mm[1]"],
        ),
        ("too few fields", SMALL.replace("fields = 5", "fields = 3"), 2, &["scan.fields", "at least 5"]),
        (
            "one master",
            SMALL.replace("[[masters.pins]]\ndiameter_mm = 12.5\nexpanded_u_mm = 0.0001", ""),
            2,
            &["masters.pins"],
        ),
        ("one angle", SMALL.replace("angles = 4", "angles = 1"), 2, &["scan.angles", "at least 2"]),
        (
            "a tolerance of another part",
            SMALL.replace("nominal_mm = 11.0", "nominal_mm = 50.0"),
            2,
            &["part.tolerance.nominal_mm", "11.0000"],
        ),
        ("no TOML", "part = [".to_owned(), 2, &["wrong.toml"]),
    ];
    let folder = tempfile::tempdir().unwrap();
    for (what, text, exit, words) in cases {
        let config = write(folder.path(), "wrong.toml", &text);
        let out = folder.path().join("out");
        let output = shadowgauge(["run", &config, "--out", &out.to_string_lossy(), "--backend", "cpu"]);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(exit), "{what}: {message}");
        assert!(words.iter().all(|w| message.contains(w)), "{what}: {words:?} not in: {message}");
        assert!(!message.contains("panicked"), "{what}: {message}");
        assert!(!out.exists(), "{what}: something was written");
    }
}

#[test]
fn a_missing_config_and_an_unknown_controller_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out").to_string_lossy().into_owned();
    let output = shadowgauge(["run", "no/such.toml", "--out", &out]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("no/such.toml"), "{}", stderr(&output));
    let output = run_small(folder.path(), "out", &["--controller", "magic"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("magic") && stderr(&output).contains("pid"), "{}", stderr(&output));
}

#[test]
fn a_run_leaves_the_files_of_the_contract_and_the_json_of_the_contract() {
    let folder = tempfile::tempdir().unwrap();
    let output = run_small(folder.path(), "out", &["--json"]);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", stderr(&output));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["controller"], "pid");
    assert_eq!(json["backend"], "cpu");
    let passes = json["passes"].as_array().unwrap();
    assert_eq!(passes.len(), 2);
    for key in [
        "pass",
        "nominal_mm",
        "max_abs_error_mm",
        "rms_error_mm",
        "true_max_abs_error_mm",
        "worst_measured_minus_true_mm",
        "frames",
        "render_s",
        "gauge_s",
    ] {
        assert!(passes[0][key].is_number(), "{key}: {}", passes[0]);
    }
    assert!(json["in_tolerance"].is_boolean());
    for name in [
        "run.toml",
        "diameters.parquet",
        "passes.csv",
        "offsets.csv",
        "stations.csv",
        "calibration.json",
        "truth.parquet",
        "timings.json",
        "report.html",
        "without_control/report.html",
    ] {
        assert!(folder.path().join("out").join(name).is_file(), "{name} is missing");
    }
    // Four angles over half a turn determine two and three lobes, not four and five.
    let mut form = csv::Reader::from_path(folder.path().join("out/form.csv")).unwrap();
    let header = form.headers().unwrap().clone();
    let row = form.records().next().unwrap().unwrap();
    let value = |name: &str| row[header.iter().position(|h| h == name).unwrap()].to_owned();
    assert!(value("lobes_2_mm").parse::<f64>().unwrap() > 0.0);
    assert_eq!((value("lobes_4_mm"), value("lobes_5_form_spindle_mm")), (String::new(), String::new()));
    assert!(value("u_gg_common_mm").parse::<f64>().unwrap() > 0.0);
    let report = std::fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(
        !report.contains("http://")
            || report.matches("http://").all(|_| report.contains("http://www.w3.org/"))
    );
    assert!(report.matches("<svg").count() >= 6, "the report has too few pictures");
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_seed_others() {
    let folder = tempfile::tempdir().unwrap();
    for (out, seed) in [("a", "5"), ("b", "5"), ("c", "6")] {
        let output = run_small(folder.path(), out, &["--no-reference", "--seed", seed]);
        assert!(matches!(output.status.code(), Some(0 | 1)), "{}", stderr(&output));
    }
    let read = |out: &str, name: &str| std::fs::read(folder.path().join(out).join(name)).unwrap();
    for name in [
        "diameters.parquet",
        "truth.parquet",
        "passes.csv",
        "stations.csv",
        "offsets.csv",
        "calibration.json",
    ] {
        assert_eq!(read("a", name), read("b", name), "{name} differs between equal runs");
    }
    assert_ne!(read("a", "stations.csv"), read("c", "stations.csv"), "the seed has no effect");
}

#[test]
fn a_taken_folder_is_refused_and_an_unwritable_one_fails() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("taken")).unwrap();
    write(&folder.path().join("taken"), "mine.txt", "keep me");
    let output = run_small(folder.path(), "taken", &[]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("mine.txt"), "{}", stderr(&output));
    assert_eq!(std::fs::read_dir(folder.path().join("taken")).unwrap().count(), 1);

    let output = run_small(folder.path(), "done", &["--no-reference"]);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", stderr(&output));
    let again = run_small(folder.path(), "done", &["--no-reference"]);
    assert_eq!(again.status.code(), Some(2), "a finished run was touched: {}", stderr(&again));

    write(folder.path(), "file", "not a folder");
    let output = run_small(folder.path(), "file/below", &[]);
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    let output = run_small(folder.path(), "file", &[]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
}

#[test]
fn a_killed_run_is_resumed_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let whole = run_small(folder.path(), "whole", &["--no-reference"]);
    assert!(matches!(whole.status.code(), Some(0 | 1)), "{}", stderr(&whole));
    // The folder after a kill in the second pass: all files of the first pass, half of the second,
    // no report.
    let source = folder.path().join("whole");
    let killed = folder.path().join("killed");
    std::fs::create_dir(&killed).unwrap();
    for name in
        ["run.toml", "calibration.json", "stations.csv", "diameters.parquet", "truth.parquet", "offsets.csv"]
    {
        std::fs::copy(source.join(name), killed.join(name)).unwrap();
    }
    let passes = std::fs::read_to_string(source.join("passes.csv")).unwrap();
    let first: String = passes.lines().take(2).map(|l| format!("{l}\n")).collect();
    write(&killed, "passes.csv", &first);
    write(&killed, ".tmp-report.html", "half");
    let resumed = run_small(folder.path(), "killed", &["--no-reference"]);
    assert!(matches!(resumed.status.code(), Some(0 | 1)), "{}", stderr(&resumed));
    for name in ["passes.csv", "stations.csv", "offsets.csv", "diameters.parquet", "truth.parquet"] {
        let read = |f: &Path| std::fs::read(f.join(name)).unwrap();
        assert_eq!(read(&source), read(&killed), "{name} differs after a resume");
    }
    // Another config must not resume the folder.
    std::fs::remove_file(killed.join("report.html")).unwrap();
    let other = run_small(folder.path(), "killed", &["--no-reference", "--seed", "9"]);
    assert_eq!(other.status.code(), Some(2), "{}", stderr(&other));
}

/// A part within U of a limit is not proven good: exit 1, and table, JSON, report and alarm agree.
#[test]
fn a_part_within_u_of_its_limit_is_not_proven_good() {
    let folder = tempfile::tempdir().unwrap();
    // The smallest diameter of the last pass and its u, from a run without a tolerance, in which no
    // guard intervenes.
    let tolerance = "[part.tolerance]\nnominal_mm = 11.0\nupper_mm = 0.01\nlower_mm = -0.01\n";
    let guards = "[control.guards]\nlower_limit_mm = 9.0\n";
    let free = SMALL.replace(tolerance, guards);
    let config = write(folder.path(), "free.toml", &free);
    let out = folder.path().join("free").to_string_lossy().into_owned();
    let run = |config: &str, out: &str| {
        shadowgauge(["run", config, "--out", out, "--backend", "cpu", "--no-reference", "--json"])
    };
    let output = run(&config, &out);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(json["in_tolerance"].is_null() && json["judgement"].is_null());
    let mut stations = csv::Reader::from_path(folder.path().join("free/stations.csv")).unwrap();
    let header = stations.headers().unwrap().clone();
    let at = |name: &str| header.iter().position(|h| h == name).unwrap();
    let smallest = stations
        .records()
        .map(Result::unwrap)
        .filter(|r| &r[at("pass")] == "2")
        .map(|r| ["d_mm", "u_random_mm", "u_common_mm"].map(|name| r[at(name)].parse::<f64>().unwrap()))
        .min_by(|a, b| a[0].total_cmp(&b[0]))
        .unwrap();
    let u_mm = smallest[1].hypot(smallest[2]);
    for (name, lower_mm, judgement) in [
        ("near", smallest[0] - u_mm - 11.0, "not_proven"),
        ("far", smallest[0] - 4.0 * u_mm - 11.0, "conforms"),
        ("out", smallest[0] + 4.0 * u_mm - 11.0, "violates"),
    ] {
        let limits =
            format!("{guards}[part.tolerance]\nnominal_mm = 11.0\nupper_mm = 0.5\nlower_mm = {lower_mm}\n");
        let text = SMALL.replace(tolerance, &limits);
        let config = write(folder.path(), "judged.toml", &text);
        let out = folder.path().join(name);
        let output = run(&config, &out.to_string_lossy());
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let good = judgement == "conforms";
        assert_eq!(output.status.code(), Some(i32::from(!good)), "{name}: {json} {}", stderr(&output));
        assert_eq!((&json["judgement"], &json["in_tolerance"]), (&judgement.into(), &good.into()), "{name}");
        assert_eq!(json["alarm"].is_null(), good);
        let report = std::fs::read_to_string(out.join("report.html")).unwrap();
        assert_eq!(report.contains("in tolerance at every station"), good, "{name}");
        assert_eq!(report.contains("NOT PROVEN IN TOLERANCE"), name == "near");
    }
}

/// A full or closed stdout ends a command with the documented exit code, never with a panic.
#[cfg(target_os = "linux")]
#[test]
fn a_full_or_closed_stdout_is_no_panic() {
    use std::process::Stdio;
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("a.png");
    image::GrayImage::from_fn(320, 200, |_, y| image::Luma([if (60..140).contains(&y) { 20 } else { 200 }]))
        .save(&picture)
        .unwrap();
    let picture = picture.to_string_lossy().into_owned();
    let full = || Stdio::from(std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap());
    for arguments in [&["schema"][..], &["measure", &picture], &["measure", &picture, "--json"]] {
        let command = || {
            let mut command = Command::new(env!("CARGO_BIN_EXE_shadowgauge"));
            command.args(arguments).env("NO_COLOR", "1").stderr(Stdio::piped());
            command
        };
        let output = command().stdout(full()).output().unwrap();
        assert_eq!(output.status.code(), Some(3), "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains("stdout cannot be written"), "{}", stderr(&output));
        let mut child = command().stdout(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).is_empty(), "{}", stderr(&output));
        // No stream can be written: only the exit code remains.
        let status = command().stdout(full()).stderr(full()).status().unwrap();
        assert_eq!(status.code(), Some(3), "{arguments:?}");
    }
}

/// A store after kills: `store check` and the passes that it lists.
fn stored_passes(store: &str) -> Vec<u32> {
    let checked = shadowgauge(["store", "check", store]);
    if said(&checked).contains("it is empty") {
        // killed before the store had its tables
        return Vec::new();
    }
    assert!(checked.status.success(), "{}{}", text(&checked.stdout), stderr(&checked));
    let listed = text(&shadowgauge(["store", "list", store, "--json"]).stdout);
    let pass =
        |line: &str| serde_json::from_str::<serde_json::Value>(line).unwrap()["pass"].as_u64().unwrap();
    let mut passes: Vec<u32> = listed.lines().map(|line| pass(line) as u32).collect();
    passes.dedup();
    passes
}

#[test]
fn every_pass_of_a_run_that_is_killed_again_and_again_is_stored_once() {
    let folder = tempfile::tempdir().unwrap();
    let config = write(folder.path(), "small.toml", SMALL);
    let store = folder.path().join("store.sqlite").to_string_lossy().into_owned();
    let out = folder.path().join("out").to_string_lossy().into_owned();
    let arguments = [
        "run",
        &config,
        "--out",
        &out,
        "--backend",
        "cpu",
        "--no-reference",
        "--store",
        &store,
        "--by",
        "Ada",
    ];
    let mut survived = Vec::new();
    for kill_after_ms in [30, 120, 250, 400, 600] {
        let mut program = Command::new(env!("CARGO_BIN_EXE_shadowgauge")).args(arguments).spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_millis(kill_after_ms));
        // a run that is finished meanwhile has nothing left to kill
        let _ = (program.kill(), program.wait());
        if Path::new(&store).metadata().is_ok_and(|file| file.len() > 0) {
            let now = stored_passes(&store);
            assert!(now.starts_with(&survived), "{survived:?} were acknowledged, {now:?} are there");
            survived = now;
        }
    }
    let finished = shadowgauge(arguments);
    let done = finished.status.success() || stderr(&finished).contains("finished");
    assert!(done, "{}", stderr(&finished));
    assert_eq!(stored_passes(&store), [1, 2]);
}

#[test]
fn a_store_that_is_none_is_refused_before_a_run_or_a_measurement_begins() {
    let folder = tempfile::tempdir().unwrap();
    let notes = write(folder.path(), "notes.txt", &"a text that is no database\n".repeat(40));
    let refused = run_small(folder.path(), "out", &["--store", &notes]);
    assert_eq!(refused.status.code(), Some(2), "{}", stderr(&refused));
    assert!(stderr(&refused).contains("no SQLite database"), "{}", stderr(&refused));
    let absent = folder.path().join("absent.sqlite").to_string_lossy().into_owned();
    for command in [["store", "check", &absent], ["store", "list", &absent], ["store", "export", &absent]] {
        assert_eq!(shadowgauge(command).status.code(), Some(2));
    }
    assert!(!Path::new(&absent).exists(), "a command that reads has made a store");
}

/// Facets of a profile (radius, Z) from the axis to the axis, 24 a turn, mm.
fn facets(profile: &[(f32, f32)]) -> Vec<[[f32; 3]; 3]> {
    let at = |(r, z): (f32, f32), k: usize| {
        let a = std::f32::consts::TAU * (k % 24) as f32 / 24.0;
        [r * a.cos(), r * a.sin(), z]
    };
    let mut all = Vec::new();
    for pair in profile.windows(2) {
        for k in 0..24 {
            let corners = [at(pair[0], k), at(pair[0], k + 1), at(pair[1], k + 1), at(pair[1], k)];
            if pair[0].0 > 0.0 {
                all.push([corners[0], corners[1], corners[2]]);
            }
            if pair[1].0 > 0.0 {
                all.push([corners[0], corners[2], corners[3]]);
            }
        }
    }
    all
}

fn binary(facets: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((facets.len() as u32).to_le_bytes());
    for facet in facets {
        bytes.extend([0; 12]);
        facet.as_flattened().iter().for_each(|v| bytes.extend(v.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn ascii(facets: &[[[f32; 3]; 3]]) -> String {
    let mut text = "solid part\n".to_owned();
    for facet in facets {
        text += "facet normal 0 0 0\nouter loop\n";
        facet.iter().for_each(|[x, y, z]| text += &format!("vertex {x:.6} {y:.6} {z:.6}\n"));
        text += "endloop\nendfacet\n";
    }
    text + "endsolid part\n"
}

/// Ø12, a cone, Ø8.
const CONE: [(f32, f32); 6] = [(0.0, 0.0), (6.0, 0.0), (6.0, 10.0), (4.0, 14.0), (4.0, 24.0), (0.0, 24.0)];
/// A collar whose side towards the chuck falls by 45°.
const COLLAR: [(f32, f32); 8] =
    [(0.0, 0.0), (6.0, 0.0), (6.0, 6.0), (4.0, 6.0), (4.0, 14.0), (6.0, 16.0), (6.0, 24.0), (0.0, 24.0)];

/// A plain part of a length, as a file.
fn facets_up_to(length_mm: f32) -> Vec<u8> {
    binary(&facets(&[(0.0, 0.0), (6.0, 0.0), (6.0, length_mm), (0.0, length_mm)]))
}

const TOOL: &str = include_str!("../configs/tool/tool.toml");
const MACHINE: &str = include_str!("../configs/tool/machine.toml");

#[test]
fn a_model_becomes_a_proven_part_in_one_command() {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("part.stl");
    std::fs::write(&model, binary(&facets(&CONE))).unwrap();
    let (model, tool) = (model.to_string_lossy().into_owned(), write(folder.path(), "tool.toml", TOOL));
    let run = |out: &str, tolerance: &str| {
        let out = folder.path().join(out).to_string_lossy().into_owned();
        let part = ["run", &model, "--unit", "mm", "--tool", &tool, "--stock", "14", "--out", &out];
        let how = ["--size-tolerance", tolerance, "--backend", "cpu", "--no-reference", "--json"];
        shadowgauge([&part[..], &how[..]].concat())
    };
    let output = run("good", "±0.02");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let report = json(&output);
    assert_eq!(report["in_tolerance"], true, "{report}");
    let last = report["passes"].as_array().unwrap().last().unwrap();
    assert!((last["nominal_mm"].as_f64().unwrap() - 12.0).abs() < 1e-5, "{last}");
    assert!(last["true_max_abs_error_mm"].as_f64().unwrap() < 0.002, "{last}");
    assert!(folder.path().join("good/report.html").is_file());
    let output = run("narrow", "±0.0001");
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
}

#[test]
fn a_model_becomes_a_program_and_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("part.stl");
    std::fs::write(&model, binary(&facets(&COLLAR))).unwrap();
    let (model, tool) = (model.to_string_lossy().into_owned(), write(folder.path(), "tool.toml", TOOL));
    let machine = write(folder.path(), "machine.toml", MACHINE);
    let svg = folder.path().join("part.svg").to_string_lossy().into_owned();
    let part = ["nc", &model, "--unit", "mm", "--tool", &tool, "--stock", "14", "--machine", &machine];
    let how = ["--from-z", "20", "--dialect", "linuxcnc", "--svg", &svg];
    let output = shadowgauge([&part[..], &how[..]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(said(&output).contains("out of the tool's reach"), "{}", said(&output));
    let program = text(&output.stdout);
    assert!(program.contains("FACED AND ROUGHED FROM A BAR OF 14. MM"), "{program}");
    assert!(std::fs::read_to_string(svg).unwrap().contains("what is left"));
}

/// (what is wrong, the file, arguments that differ, exit code, words of the error)
#[test]
fn a_model_that_makes_no_program_is_one_clear_error() {
    let good = binary(&facets(&CONE));
    let words = ascii(&facets(&CONE));
    let not_a_number = words.replacen("vertex 6.000000", "vertex NaN", 1);
    let commas = words.replace('.', ",");
    let png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".repeat(20);
    let unmade = |name: &str, bytes: &[u8], more: &[&str], code: i32, words: &[&str]| {
        let folder = tempfile::tempdir().unwrap();
        let model = folder.path().join("part.stl");
        std::fs::write(&model, bytes).unwrap();
        let model = model.to_string_lossy().into_owned();
        let tool = write(folder.path(), "tool.toml", TOOL);
        write(folder.path(), "boring.toml", include_str!("../configs/tool/boring_tool.toml"));
        let machine = write(folder.path(), "machine.toml", MACHINE);
        let out = folder.path().join("part.ngc").to_string_lossy().into_owned();
        let mut arguments = vec!["nc", &model, "--machine", &machine, "--dialect", "linuxcnc", "--out", &out];
        for (key, value) in [("--unit", "mm"), ("--tool", &tool), ("--stock", "14"), ("--from-z", "20")] {
            if !more.contains(&key) {
                arguments.extend([key, value]);
            }
        }
        let boring = folder.path().join("boring.toml").to_string_lossy().into_owned();
        arguments.extend(more.iter().map(|word| if *word == "BORING" { &boring[..] } else { *word }));
        let output = shadowgauge(&arguments);
        let said = said(&output);
        assert_eq!(output.status.code(), Some(code), "{name}: {said}");
        assert!(words.iter().all(|word| said.contains(word)), "{name}: {said}");
        assert!(!Path::new(&out).exists(), "{name}: half written");
    };
    unmade("a letter", &b"Dear Sir or Madam,\n".repeat(30), &[], 3, &["part.stl", "solid"]);
    unmade("a picture", &png, &[], 3, &["a PNG image"]);
    unmade("cut off", &good[..good.len() - 100], &[], 3, &["cut off"]);
    unmade("no number", not_a_number.as_bytes(), &[], 3, &["line 6", "NaN"]);
    unmade("commas", commas.as_bytes(), &[], 3, &["line 4", "decimal points"]);
    unmade("inches", &good, &["--unit", "inch"], 2, &["--unit mm would make it 12.000 mm"]);
    unmade("a thin bar", &good, &["--stock", "11"], 2, &["12.0000 mm", "another bar"]);
    unmade("all in the grip", &facets_up_to(14.0), &["--from-z", "0"], 2, &["in the grip", "--from-z"]);
    unmade("a boring tool", &good, &["--tool", "BORING"], 2, &["external"]);
    unmade("a depth of none", &good, &["--depth", "0"], 2, &["depth"]);
    unmade("a tolerance", &good, &["--size-tolerance", "h7"], 2, &["run part.stl"]);
}
