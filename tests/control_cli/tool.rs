//! `tool compensate` from outside: what it prints and writes, and what it refuses.

use std::path::{Path, PathBuf};

use super::assert_refused;
use super::program::{said, shadowgauge, text};

/// A file of the example.
fn example(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/tool").join(name).display().to_string()
}

/// The example's arguments with other files in place of some.
fn arguments(with: &[(&str, String)], more: &[&str]) -> Vec<String> {
    let files = [
        ("--nose", "nose.json"),
        ("--tool", "tool.toml"),
        ("--part", "outline.toml"),
        ("--machine", "machine.toml"),
    ];
    let mut all = vec!["tool".to_owned(), "compensate".to_owned()];
    for (key, name) in files {
        let given = with.iter().find(|w| w.0 == key).map(|w| w.1.clone());
        all.extend([key.to_owned(), given.unwrap_or_else(|| example(name))]);
    }
    all.extend(more.iter().map(|m| (*m).to_owned()));
    all
}

fn refused(with: &[(&str, String)], more: &[&str], exit: i32, words: &[&str]) {
    let all = arguments(with, more);
    assert_refused(&all.iter().map(String::as_str).collect::<Vec<_>>(), exit, words);
}

#[test]
fn every_way_is_listed_and_the_program_leaves_what_it_states() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("nose").display().to_string();
    let output = shadowgauge(arguments(&[], &["--json", "--out", &out]));
    assert!(output.status.success(), "{}", said(&output));
    let document: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let ways = document["ways"].as_array().expect("ways");
    let largest = |way: &str| {
        let found = ways.iter().find(|w| w["way"] == way).expect("the way");
        found["largest"]["left_um"].as_f64().expect("a value").abs()
    };
    // (R0 - r)(c + s - 1) less the wear: 6.608 um at 45 degrees of the paper's nose
    assert!((largest("register") - 6.608).abs() < 0.02, "{document:#}");
    assert!(largest("best_register") < 2.5 && largest("edited_contour") < 0.03 && largest("path") < 0.03);
    assert!(document["program_largest"]["left_um"].as_f64().is_some_and(|left| left.abs() < 0.1));
    for name in ["compensation.json", "left.csv", "path.csv", "program.nc", "path.svg", "left.svg"] {
        assert!(PathBuf::from(&out).join(name).metadata().is_ok_and(|m| m.len() > 300), "{name}");
    }
    let program = std::fs::read_to_string(PathBuf::from(&out).join("program.nc")).expect("the program");
    assert!(program.contains("G03") && program.contains("G40") && !program.contains("G42"), "{program}");
    refused(&[], &["--out", &out], 2, &["is not empty"]);

    let fanuc = folder.path().join("fanuc.toml");
    let machine = std::fs::read_to_string(example("machine.toml")).expect("the machine");
    let stated = "wear_x = \"diameter\"\ngeometry_offset = \"by_tool\"\nspindle = \"M03\"\n";
    std::fs::write(&fanuc, stated.to_owned() + &machine).expect("written");
    let fanuc = fanuc.display().to_string();
    let output = shadowgauge(arguments(
        &[("--machine", fanuc.clone())],
        &["--way", "best-register", "--dialect", "fanuc"],
    ));
    assert!(output.status.success(), "{}", said(&output));
    let text = text(&output.stdout);
    for word in ["G10 P10001 R0.41", "Q3", "G10 P1 R0.", "G42 ", "G40 G01"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    // the same machine with the paper's control, which is given radius and tip by hand
    let output = shadowgauge(arguments(&[("--machine", fanuc)], &["--way", "register", "--dialect", "gsk"]));
    assert!(output.status.success(), "{}", said(&output));
    let text = self::text(&output.stdout);
    for word in ["SET BY HAND: OFFSET 01, R 0.4, T 3", "NOT VERIFIED ON A CONTROL", "G42 ", "G40 G01"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    assert!(!text.contains("G10"), "{text}");
}

#[test]
fn files_that_do_not_fit_are_refused_with_their_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let changed = |name: &str, from: &str, to: &str| {
        let text = std::fs::read_to_string(example(name)).expect("an example");
        assert!(text.contains(from), "{from}");
        let path = folder.path().join(name);
        std::fs::write(&path, text.replacen(from, to, 1)).expect("written");
        path.display().to_string()
    };
    let tool = |from: &str, to: &str| [("--tool", changed("tool.toml", from, to))];
    refused(
        &tool("tip_direction = 3", "tip_direction = 2"),
        &[],
        2,
        &["tip_direction", "3 for a tool set in X"],
    );
    refused(
        &tool("epsilon_r_deg = 60.0", "epsilon_r_deg = 90.0"),
        &[],
        2,
        &["epsilon_r_deg", "trailing edge"],
    );
    refused(&tool("plus_z_deg = 0.0", "plus_z_deg = 20.0"), &[], 2, &["image.plus_z_deg", "right angles"]);
    refused(&tool("kappa_r_deg = 93.0", "kappa_r_deg = 80.0"), &[], 2, &["cannot be the tool's", "90.000"]);
    refused(&tool("kappa_r_deg", "kappa_deg"), &[], 2, &["kappa_deg"]);
    let part = |from: &str, to: &str| [("--part", changed("outline.toml", from, to))];
    refused(
        &part("radius_mm = 2.0", "radius_mm = 0.3"),
        &["--way", "register"],
        2,
        &["gouges", "smaller than"],
    );
    refused(&part("stock_diameter_mm = 32.0", "stock_diameter_mm = 30.0"), &[], 2, &["stock_diameter_mm"]);
    refused(&part("stock_diameter_mm", "side = \"internal\"\nstock_diameter_mm"), &[], 2, &["side"]);
    let nose = |from: &str, to: &str| [("--nose", changed("nose.json", from, to))];
    refused(&nose("\"support\"", "\"supports\""), &[], 2, &["--image NAME", "nose_004"]);
    refused(&nose("\"h_um\": 374.3000", "\"h_um\": 380.0"), &[], 2, &["convex hull", "nose_004"]);
    refused(&[("--nose", "no_such.json".to_owned())], &[], 3, &["no_such.json"]);
    // a register that no control takes, and a cut unlike the pass that was measured
    refused(
        &tool("tip_direction = 3", "tip_direction = 3\nregister_mm = 1200.0"),
        &["--way", "register"],
        2,
        &["1200.00000 mm", "0.001 to 999.999 mm", "register_mm"],
    );
    let (speed, feed) = ("speed_m_per_min = 180.0", "feed_mm_per_rev = 0.08");
    refused(
        &part(speed, "speed_m_per_min = 200.0"),
        &[],
        2,
        &["cutting.speed_m_per_min", "200", "180 m/min", "measured"],
    );
    refused(&part(feed, "feed_mm_per_rev = 0.1"), &[], 2, &["cutting.feed_mm_per_rev", "0.1", "0.08 mm"]);
    refused(&part("depth_mm = 0.2", "depth_mm = 0.5"), &[], 2, &["depth_mm", "0.5000 mm", "0.2 mm"]);
    let both = [tool("depth_mm = 0.2", "depth_mm = -1.0"), part("depth_mm = 0.2", "depth_mm = 0.0")];
    refused(&both[0], &[], 2, &["measured_pass.depth_mm"]);
    refused(&both[1], &[], 2, &["depth_mm", "above 0"]);
}

#[test]
fn a_bore_gets_its_program_where_the_bar_is_stated() {
    let files = [
        ("--tool", example("boring_tool.toml")),
        ("--part", example("bore.toml")),
        ("--machine", example("boring_machine.toml")),
    ];
    let output = shadowgauge(arguments(&files, &["--json"]));
    assert!(output.status.success(), "{}", said(&output));
    let document: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert!(
        document["program_largest"]["left_um"].as_f64().is_some_and(|left| left.abs() < 0.1),
        "{document:#}"
    );
    assert!(document["no_program"].is_null() && document["cautions"].is_null(), "{document:#}");
    let output = shadowgauge(arguments(&files, &["--way", "register"]));
    let printed = text(&output.stdout);
    for word in ["G41.1 D0.8 L3", "G00 Z120.\nX200.", "BORING BAR OF 4 MM", "Z GOES FIRST"] {
        assert!(printed.contains(word), "{word}: {printed}");
    }
    // no bar, no program; the rest is there
    let files = [files[0].clone(), files[1].clone(), ("--machine", example("machine.toml"))];
    let output = shadowgauge(arguments(&files, &["--json"]));
    assert!(output.status.success(), "{}", said(&output));
    let document: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert!(document["no_program"].as_str().is_some_and(|why| why.contains("boring_bar")), "{document:#}");
    assert!(document["dialect"].is_null() && document["ways"].as_array().is_some_and(|ways| ways.len() == 4));
}
