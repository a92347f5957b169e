//! The process' studies from outside the binary.

use std::path::Path;

use crate::inside::process_studies::program::shadowgauge;

fn json(arguments: &[&str]) -> serde_json::Value {
    let output = shadowgauge(arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Runs with a config of this text; returns the exit code and stderr.
fn refused(command: &[&str], config: &str) -> (i32, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("config.toml");
    std::fs::write(&path, config).unwrap();
    let mut arguments = command.to_vec();
    arguments.push(path.to_str().unwrap());
    let output = shadowgauge(&arguments);
    (output.status.code().unwrap(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// One clear error: the exit code, and every word in it.
fn assert_refused(command: &[&str], config: &str, exit: i32, words: &[&str]) {
    let (code, text) = refused(command, config);
    assert_eq!(code, exit, "{text}");
    // Lines may be broken anywhere at the width of the terminal.
    let flat = |t: &str| t.chars().filter(|c| !c.is_whitespace() && *c != '│').collect::<String>();
    for word in words {
        assert!(flat(&text).contains(&flat(word)), "{word:?} is missing in: {text}");
    }
    assert!(!text.contains("panicked"), "{text}");
}

#[test]
fn deflection_of_the_papers_beam() {
    let found = json(&["study", "deflection", "configs/beam_003.toml", "--at", "500", "250.5", "--json"]);
    let at = |i: usize| found["positions"][i]["compliance_mm_per_n"].as_f64().unwrap();
    assert_eq!(found["positions"][0]["z_mm"], 500.0);
    assert!((at(0) / 1.434993110672e-4 - 1.0).abs() < 1e-9, "{}", at(0));
    assert!(at(1) < at(0));
    let max = &found["max"];
    assert!((max["z_mm"].as_f64().unwrap() - 585.21).abs() < 0.01, "{max}");
    assert!((2e3 * max["compliance_mm_per_n"].as_f64().unwrap() - 0.30848).abs() < 5e-6, "{max}");
}

#[test]
fn deflection_reads_a_job_and_writes_a_page() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("deflection");
    let out_text = out.to_str().unwrap();
    json(&["study", "deflection", "configs/slender_shaft.toml", "--json", "--out", out_text]);
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("<svg") && !page.contains("http://www.example"));
    assert!(
        std::fs::read_to_string(out.join("deflection.csv")).unwrap().starts_with("z_mm,compliance_mm_per_n")
    );
    let taken = shadowgauge(["study", "deflection", "configs/beam_003.toml", "--out", out_text]);
    assert_eq!(taken.status.code(), Some(2));
}

#[test]
fn deflection_refuses_what_cannot_be() {
    let command = ["study", "deflection"];
    let part = "[part]\nlength_mm = 1000.0\nstock_diameter_mm = 50.0\n";
    assert_refused(&command, "[part]\nlength_cm = 3.0\n", 2, &["length_cm", "length_mm"]);
    assert_refused(
        &command,
        "[part]\nlength_mm = -3.0\nstock_diameter_mm = 50.0\n",
        2,
        &["part.length_mm", "above 0"],
    );
    let unknown = format!("{part}[process.material]\nname = \"wood\"\n");
    assert_refused(&command, &unknown, 2, &["process.material.name", "wood", "C45"]);
    let kienzle = format!("{part}[process.material]\nname = \"EN AW-6082\"\n[process.force.kienzle]\n");
    assert_refused(&command, &kienzle, 2, &["process.force.kienzle.kc11_n_per_mm2", "EN AW-6082"]);
    let overlapping = format!(
        "{part}steps = [{{ from_mm = 0.0, to_mm = 200.0, diameter_mm = 60.0 }}, {{ from_mm = 100.0, to_mm = 300.0, diameter_mm = 55.0 }}]\n"
    );
    assert_refused(&command, &overlapping, 2, &["steps[1].from_mm", "overlap"]);
    let outside = shadowgauge(["study", "deflection", "configs/beam_003.toml", "--at", "1200"]);
    assert_eq!(outside.status.code(), Some(2));
    let missing = shadowgauge(["study", "deflection", "configs/no_such.toml"]);
    assert_eq!(missing.status.code(), Some(2));
    assert!(Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/beam_003.toml").exists());
}

fn optimize_config(from: &str, to: &str) -> String {
    let text = include_str!("../../../configs/optimize_003.toml");
    assert!(text.contains(from), "{from}");
    text.replace(from, to)
}

#[test]
fn optimize_prints_the_optimum_and_writes_the_front() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("front");
    let found = json(&["optimize", "configs/optimize_003.toml", "--json", "--out", out.to_str().unwrap()]);
    assert_eq!(found["feasible"], true);
    assert!((found["optimum"]["time_min"].as_f64().unwrap() - 15.7616).abs() < 2e-3);
    assert!(found["genetic"]["gap"].as_f64().unwrap() < 2e-3);
    // The last generation's best is the answer; the total of two passes is more than twice eq. 5's
    // second, less than twice its first.
    let generations = found["genetic"]["generations"].as_array().unwrap();
    assert_eq!(generations.last().unwrap()["time_min"], found["genetic"]["solution"]["time_min"]);
    let (one, two) = (&found["passes"][0], &found["passes"][1]);
    let number = |v: &serde_json::Value| v.as_f64().unwrap();
    let total = number(&two["total_min"]) - 0.5;
    assert!(total > 2.0 * number(&two["equation_5_min"]) && total < 2.01 * number(&one["equation_5_min"]));
    assert!(out.join("generations.svg").exists() && out.join("passes.svg").exists());
    assert!(std::fs::read_to_string(out.join("front.svg")).unwrap().contains("<svg"));
    assert!(std::fs::read_to_string(out.join("front.csv")).unwrap().lines().count() > 20);
    let seven = json(&["optimize", "configs/optimize_003.toml", "--json", "--seed", "7"]);
    assert_ne!(found["genetic"]["solution"], seven["genetic"]["solution"]);
    assert_eq!(found["optimum"], seven["optimum"]);
}

#[test]
fn optimize_calls_an_infeasible_problem_infeasible() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table_1.toml");
    std::fs::write(&path, optimize_config("coefficient_n = 521.2", "coefficient_n = 4764.2")).unwrap();
    let output = shadowgauge(["optimize", path.to_str().unwrap(), "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        (&found["feasible"], &found["conflict"]["constraints"][0]),
        (&false.into(), &"size_error".into())
    );
    let words = shadowgauge(["optimize", path.to_str().unwrap()]);
    assert!(String::from_utf8_lossy(&words.stdout).contains("infeasible"));
}

#[test]
fn optimize_refuses_what_cannot_be() {
    let command = ["optimize"];
    let crossed = optimize_config("speed_m_per_min = [30.0, 80.0]", "speed_m_per_min = [80.0, 30.0]");
    assert_refused(&command, &crossed, 2, &["limits.speed_m_per_min[1]", "exclude each other"]);
    let reserve = optimize_config("reserve_mm = 0.01", "reserve_mm = 0.05");
    assert_refused(&command, &reserve, 2, &["quality.reserve_mm", "below"]);
    let unknown = optimize_config("roughness_um", "roughness_mm");
    assert_refused(&command, &unknown, 2, &["roughness_mm", "roughness_um"]);
    let deep = optimize_config("depth_mm = [0.2, 1.0]", "depth_mm = [0.2, 30.0]");
    assert_refused(&command, &deep, 2, &["limits.depth_mm[1]", "leave a shaft"]);
}

#[test]
fn factor_runs_the_papers_series_and_a_table_of_ones_own() {
    let found = json(&["study", "factor", "--json"]);
    let deviation =
        |series: usize, row: usize| found["series"][series]["rows"][row]["deviation"].as_f64().unwrap();
    for row in [0, 2, 4, 6] {
        assert!(deviation(0, row).abs() <= 0.02, "{}", deviation(0, row));
    }
    for row in [0, 2, 4] {
        assert!(deviation(1, row).abs() <= 0.08, "{}", deviation(1, row));
    }
    for row in 0..4 {
        assert!(deviation(2, row).abs() <= 0.05, "{}", deviation(2, row));
    }
    assert!((found["error_per_force_um_per_n"].as_f64().unwrap() - 0.30848).abs() < 1e-5);
    let elasticity = found["series"][2]["elasticity"].as_f64().unwrap();
    assert!((elasticity - 0.6).abs() < 1e-9, "{elasticity}");
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("factor");
    let fitted = json(&[
        "study",
        "factor",
        "--forces",
        "configs/paper_003/table_1.csv",
        "--json",
        "--out",
        out.to_str().unwrap(),
    ]);
    let x = &fitted["fitted"]["estimates"][1];
    assert_eq!(x["name"], "depth_exponent");
    assert!(x["interval"][0].as_f64().unwrap() < 0.9014 && x["interval"][1].as_f64().unwrap() > 0.9014);
    assert!(std::fs::read_to_string(out.join("series_3_z.svg")).unwrap().contains("<svg"));
    assert!(out.join("report.html").exists() && out.join("factor.csv").exists());
}

#[test]
fn factor_refuses_what_cannot_be() {
    let command = ["study", "factor"];
    let text = include_str!("../../../configs/factor_003.toml");
    assert_refused(
        &command,
        &text.replacen("force_n = [49.84, ", "force_n = [", 1),
        2,
        &["series[0].force_n", "7 entries for 8"],
    );
    assert_refused(
        &command,
        &text.replacen("confidence = 0.95", "confidence = 95", 1),
        2,
        &["confidence", "below 1"],
    );
    assert_refused(
        &command,
        &text.replacen("feed_mm_per_rev\"", "feed_in\"", 1),
        2,
        &["feed_in", "feed_mm_per_rev"],
    );
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("forces.csv");
    std::fs::write(&table, "depth_mm,speed_m_per_min,feed_mm_per_rev,force_n\n0.1,40,0.1,oops\n").unwrap();
    let output = shadowgauge(["study", "factor", "--forces", table.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(3));
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(words.contains("forces.csv") && words.contains("oops") || words.contains("float"), "{words}");
}

/// The main job's config with tables appended.
fn job_with(tables: &str) -> String {
    format!("{}\n{tables}", include_str!("../../../configs/slender_shaft.toml"))
}

#[test]
fn a_run_refuses_a_shaft_too_slender_to_cut_and_a_material_without_data() {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("job.toml");
    let out = folder.path().join("run");
    let attempt = |tables: &str| {
        std::fs::write(&config, job_with(tables)).unwrap();
        let output = shadowgauge([
            "run",
            config.to_str().unwrap(),
            "--out",
            out.to_str().unwrap(),
            "--backend",
            "cpu",
            "--no-reference",
        ]);
        let text: String = String::from_utf8_lossy(&output.stderr)
            .chars()
            .filter(|c| !c.is_whitespace() && *c != '│')
            .collect();
        assert!(!text.contains("panicked"), "{text}");
        (output.status.code().unwrap(), text)
    };
    let unknown = attempt("[process.material]\nname = \"wood\"\n");
    assert!(unknown.0 == 2 && unknown.1.contains("wood") && unknown.1.contains("42CrMo4"), "{unknown:?}");
    let untabled = attempt("[process.material]\nname = \"X5CrNi18-10\"\n[process.force.kienzle]\n");
    assert!(untabled.0 == 2 && untabled.1.contains("kc11_n_per_mm2"), "{untabled:?}");
    assert!(!out.exists(), "a refused config must not touch the disk");
    let thrust = attempt("[process.support]\ntailstock_thrust_n = 1.0e6\n");
    assert!(thrust.0 >= 2 && thrust.1.contains("wouldbuckleinpass1"), "{thrust:?}");
    std::fs::remove_dir_all(&out).unwrap();
    let soft =
        "[process.support]\ntailstock_n_per_um = 0.0\n[process.material]\nyoungs_modulus_n_per_mm2 = 5.0e4\n";
    let slender = attempt(soft);
    assert!(
        slender.0 >= 2 && slender.1.contains("minimumchip") && slender.1.contains("deflection"),
        "{slender:?}"
    );
}

#[test]
fn forces_outside_the_fitted_range_are_said_to_be_extrapolated() {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("job.toml");
    let out = folder.path().join("run");
    // feed .4 mm/r: the papers' tables end at .35
    let text = include_str!("../../../configs/slender_shaft.toml")
        .replace("feed_mm_per_rev = 0.1", "feed_mm_per_rev = 0.4")
        .replace("angles = 8", "angles = 2");
    std::fs::write(&config, text).unwrap();
    let arguments = [
        "run",
        config.to_str().unwrap(),
        "--out",
        out.to_str().unwrap(),
        "--backend",
        "cpu",
        "--no-reference",
    ];
    let output = shadowgauge([&arguments[..], &["--passes", "1"]].concat());
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(words.contains("the force law is extrapolated: feed 0.4"), "{words}");
}
