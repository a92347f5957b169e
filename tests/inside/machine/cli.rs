//! `study machine` from outside: points, files, and refusals with file, key and remedy.

use crate::inside::support::program::{json, said, shadowgauge};

const PRESET: &str = "configs/machine_001.toml";

#[test]
fn positions_are_answered_alone() {
    let found =
        json(&shadowgauge(["study", "machine", PRESET, "--at", "50,20", "--at", "-25,80.5", "--json"]));
    let points = found["points"].as_array().unwrap();
    assert_eq!(points.len(), 2);
    assert_eq!((points[1]["x_mm"].as_f64(), points[1]["z_mm"].as_f64()), (Some(-25.0), Some(80.5)));
    for point in points {
        for axis in ["e_x_um", "e_y_um", "e_z_um"] {
            let (exact, linear) =
                (point[axis].as_f64().unwrap(), point["first_order"][axis].as_f64().unwrap());
            assert!(exact.abs() < 5.0 && (exact - linear).abs() < 1e-4, "{axis}: {exact} {linear}");
        }
    }
    for (at, words) in [("50", "X,Z in mm"), ("50,abc", "X,Z in mm"), ("500,20", "-50 to 100 mm")] {
        let output = shadowgauge(["study", "machine", PRESET, "--at", at]);
        assert_eq!(output.status.code(), Some(2), "{at}");
        assert!(said(&output).contains(words), "{at}: {}", said(&output));
    }
}

#[test]
fn the_page_and_its_tables_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("machine");
    let output = shadowgauge(["study", "machine", PRESET, "--out", out.to_str().unwrap()]);
    assert!(output.status.success(), "{}", said(&output));
    for name in [
        "map.csv",
        "budget.csv",
        "heads.csv",
        "readings.csv",
        "form.csv",
        "aliases.csv",
        "space.svg",
        "readings.svg",
        "report.html",
    ] {
        assert!(out.join(name).metadata().is_ok_and(|m| m.len() > 200), "{name}");
    }
    let rows = std::fs::read_to_string(out.join("map.csv")).unwrap().lines().count();
    assert_eq!(rows, 51 * 51 + 1);
}

#[test]
fn tables_in_files_stand_beside_the_config() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("my.toml");
    let text = std::fs::read_to_string(PRESET).unwrap();
    let named = text.replace(
        "table = { position_mm = [0.0, 25.0, 50.0, 75.0, 100.0], value_urad = [0.0, 0.5, 0.3, -0.2, -0.6] }",
        "table = { file = \"ebz.csv\" }",
    );
    assert_ne!(named, text);
    std::fs::write(&path, named).unwrap();
    let ask = |config: &str| shadowgauge(["study", "machine", config, "--at", "30,60", "--json"]);
    let config = path.to_str().unwrap();
    let refused = ask(config);
    assert_eq!(refused.status.code(), Some(2));
    assert!(said(&refused).contains("ebz.csv: cannot be read"), "{}", said(&refused));
    std::fs::write(folder.path().join("ebz.csv"), "position_mm,value_um\n0,0\n100,1\n").unwrap();
    let wrong = said(&ask(config));
    for word in ["machine.errors.ebz.table.file", "ebz.csv", "no column value_urad"] {
        assert!(wrong.contains(word), "'{word}' is missing in: {wrong}");
    }
    let rows = "position_mm,value_urad\n0,0.0\n25,0.5\n50,0.3\n75,-0.2\n100,-0.6\n";
    std::fs::write(folder.path().join("ebz.csv"), rows).unwrap();
    assert_eq!(json(&ask(config)), json(&ask(PRESET)));
}

#[test]
fn what_is_refused_is_named_with_file_and_key() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("my.toml");
    let text = std::fs::read_to_string(PRESET).unwrap();
    for (from, to, words) in [
        ("carriage_mm = [0.0, 100.0, 100.0]", "", vec!["carriage_mm"]),
        (
            "amplitude_um = 0.06",
            "amplitude_um = 6000.0",
            vec!["machine.errors.ezx.fourier[0].amplitude_um", "in nm?"],
        ),
        (
            "[0.0, 25.0, 50.0, 75.0, 100.0]",
            "[0.0, 25.0, 50.0, 75.0, 90.0]",
            vec!["machine.errors.ebz.table.position_mm", "from 0 to 100 mm"],
        ),
        ("chain = \"t_shaped\"", "chain = \"t\"", vec!["chain", "t_shaped"]),
    ] {
        assert!(text.contains(from), "{from}");
        std::fs::write(&path, text.replace(from, to)).unwrap();
        let output = shadowgauge(["study", "machine", path.to_str().unwrap(), "--json"]);
        assert_eq!(output.status.code(), Some(2), "{to}");
        let text = said(&output);
        for word in words.iter().chain(&["my.toml"]) {
            assert!(text.contains(word), "'{word}' is missing in: {text}");
        }
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn speed_and_coverage_are_commands() {
    let speed = json(&shadowgauge(["study", "machine", PRESET, "--bench", "2", "--json"]));
    assert_eq!((speed["points"].as_u64(), speed["rounds"].as_u64()), (Some(51 * 51), Some(2)));
    assert!(speed["points_per_s_max"].as_f64().is_some_and(|rate| rate > 1e3), "{speed}");
    let plan = "configs/machine_coverage.toml";
    let covered = json(&shadowgauge(["study", "machine-coverage", plan, "--machines", "2", "--json"]));
    assert_eq!(covered["machines"].as_u64(), Some(2));
    assert_eq!(covered["figures"].as_array().map(Vec::len), Some(3));
    assert!(covered["together"]["within_percent"].as_f64().is_some(), "{covered}");
    let refused = shadowgauge(["study", "machine-coverage", plan, "--machines", "0"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(said(&refused).contains("--machines"), "{}", said(&refused));
}

/// Frames of a scan as readings of a midline; a scan over half a turn lacks the opposite angles,
/// and `calibrate machine` says so.
#[test]
fn midlines_of_frames_are_readings() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let rendered =
        shadowgauge(["render", "configs/small_shaft.toml", "--out", &at("scan"), "--frames", "16"]);
    assert!(rendered.status.success(), "{}", said(&rendered));
    let csv = at("midline.csv");
    let measured =
        shadowgauge(["measure", &at("scan/frames"), "--um-per-px", "file", "--midline", &csv, "--json"]);
    assert!(measured.status.success(), "{}", said(&measured));
    let text = std::fs::read_to_string(&csv).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "axis,position_mm,direction,run,error,value,unit,angle_deg");
    assert_eq!(lines.len(), 1 + 2 * 16);
    assert!(
        lines[1].starts_with("Z,") && lines[1].contains(",forward,1,midline,0.000000,um,0"),
        "{}",
        lines[1]
    );
    let one =
        shadowgauge(["measure", &at("scan/frames/000000.png"), "--um-per-px", "file", "--midline", &csv]);
    assert_eq!(one.status.code(), Some(2), "{}", said(&one));
    assert!(said(&one).contains("frames.csv"), "{}", said(&one));
    assert_eq!(std::fs::read_to_string(&csv).unwrap(), text, "nothing half-written");
    let config = include_str!("../../../configs/machine_identify.toml");
    let set = config.rsplit("[[readings]]").next().unwrap();
    let set = set.split("\nplan").next().unwrap().replace("instrument", "file = \"midline.csv\"\ninstrument");
    let head = config.split("\n[simulate]").next().unwrap().replace("\"ezz\", ", "");
    std::fs::write(at("my.toml"), format!("{head}[[readings]]{set}\n")).unwrap();
    let refused = shadowgauge(["calibrate", "machine", &at("my.toml"), "--out", &at("machine.json")]);
    assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
    assert!(said(&refused).contains("without 180"), "{}", said(&refused));
}
