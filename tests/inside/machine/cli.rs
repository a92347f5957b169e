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
