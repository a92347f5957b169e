//! `calibrate machine` from outside, and a run whose control takes what it identified.

use std::path::Path;

use crate::config;
use crate::identification::IdentifiedMachine;
use crate::inside::support::program::{said, shadowgauge};

const IDENTIFY: &str = include_str!("../../../configs/machine_identify.toml");
const LATHE: &str = include_str!("../../../configs/machine/lathe.toml");
const RUN: &str = include_str!("../../../configs/machine_run.toml");

/// A folder with a lathe, its readings in files and a config that names them.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("truth.toml"), LATHE).unwrap();
    std::fs::write(at("simulated.toml"), IDENTIFY.replace("machine/lathe.toml", "truth.toml")).unwrap();
    let tables = at("tables");
    let output =
        calibrate(folder.path(), "simulated.toml", "simulated.json", &["--tables", tables.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let mut read: toml::Table = toml::from_str(IDENTIFY).unwrap();
    read.remove("simulate");
    for (k, set) in read["readings"].as_array_mut().unwrap().iter_mut().enumerate() {
        let set = set.as_table_mut().unwrap();
        set.remove("plan");
        set.insert("file".into(), format!("tables/readings_{k}.csv").into());
    }
    std::fs::write(at("read.toml"), toml::to_string(&read).unwrap()).unwrap();
    folder
}

fn calibrate(folder: &Path, config: &str, out: &str, more: &[&str]) -> std::process::Output {
    let (config, out) = (folder.join(config), folder.join(out));
    let mut arguments =
        vec!["calibrate", "machine", config.to_str().unwrap(), "--out", out.to_str().unwrap()];
    arguments.extend(more);
    shadowgauge(arguments)
}

/// The rows of the first pass of a run with a table: what the control subtracts and what is left,
/// µm.
fn rows(folder: &Path) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let job = config::load(&folder.join("run.toml")).unwrap();
    let rows = job.machine_rows(1).unwrap();
    let of = |f: fn(&crate::job::MachineRow) -> f64| rows.iter().map(f).collect::<Vec<f64>>();
    (of(|row| row.compensated_um), of(|row| row.left_um), of(|row| row.cut_um))
}

fn range(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::MIN, f64::max) - values.iter().copied().fold(f64::MAX, f64::min)
}

#[test]
fn the_truth_changes_nothing_of_what_was_identified() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    for name in ["errors.csv", "compensation.csv", "positioning.csv", "linuxcnc_x.comp", "linuxcnc_z.comp"] {
        assert!(at("tables").join(name).metadata().is_ok_and(|m| m.len() > 100), "{name}");
    }
    let output = calibrate(folder.path(), "read.toml", "machine.json", &[]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let before = std::fs::read(at("machine.json")).unwrap();
    let run = RUN
        .replace("machine/lathe.toml\"", "truth.toml\"\ntable = \"machine.json\"\nhead = \"telecentric 12\"")
        .replace("compensate = false", "compensate = true");
    std::fs::write(at("run.toml"), &run).unwrap();
    let (compensated, left, cut) = rows(folder.path());
    // constants are the set-up of the tool; the rest is taken out to some tenths
    assert!(range(&cut) > 8.0 && range(&left) < 0.6, "{} {}", range(&cut), range(&left));
    std::fs::write(at("truth.toml"), LATHE.replace("amplitude_um = 2.0", "amplitude_um = 20.0")).unwrap();
    let output = calibrate(folder.path(), "read.toml", "machine.json", &[]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert_eq!(std::fs::read(at("machine.json")).unwrap(), before);
    let (after, left, _) = rows(folder.path());
    assert_eq!(after, compensated, "the control's table is of machine.json alone");
    assert!(range(&left) > 10.0, "{}", range(&left));
    refusals_of_a_run(folder.path(), &run);
}

/// A file of another machine or head, and one whose readings end within the part.
fn refusals_of_a_run(folder: &Path, run: &str) {
    let at = |name: &str| folder.join(name);
    let refused = |text: &str| {
        std::fs::write(at("run.toml"), text).unwrap();
        config::load(&at("run.toml")).err().unwrap().to_string()
    };
    let other = refused(&run.replace("head = \"telecentric 12\"", "name = \"another\""));
    assert!(other.contains("machine.table") && other.contains("not on 'another'"), "{other}");
    let other = refused(&run.replace("telecentric 12", "entocentric"));
    assert!(other.contains("the head 'telecentric 12'"), "{other}");
    let text = std::fs::read_to_string(at("machine.json")).unwrap();
    let mut short = IdentifiedMachine::read(&text).unwrap();
    short.machine.z_travel_mm[1] = 50.0;
    std::fs::write(at("machine.json"), serde_json::to_string(&short).unwrap()).unwrap();
    let beyond = refused(run);
    assert!(beyond.contains("part.length_mm") && beyond.contains("none is extrapolated"), "{beyond}");
    std::fs::write(at("machine.json"), "{\"scale_mm_per_px\": 0.017}").unwrap();
    let other = refused(run);
    assert!(other.contains("machine.json") && other.contains("its format is 'none'"), "{other}");
}

#[test]
fn what_is_refused_writes_nothing_and_what_is_not_separated_is_exit_1() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("truth.toml"), LATHE).unwrap();
    let text = IDENTIFY.replace("machine/lathe.toml", "truth.toml");
    for (from, to, words) in [
        ("quantities = [\"ezz\"] }", "quantities = [\"ecz\"] }", "not read by a laser"),
        ("u_urad = 0.3\nplan", "u_urad = 0.3\nfile = \"none.csv\"\nplan", "none.csv: cannot be read"),
        ("carriage_mm = [0.0, 250.0, -80.0]", "carriage_mm = [0.0, 250.0, -81.0]", "other levers"),
        ("identify = [\"exz\"", "identify = [\"exz\", \"eyx\"", "EYX"),
    ] {
        assert!(text.contains(from), "{from}");
        std::fs::write(at("my.toml"), text.replace(from, to)).unwrap();
        let output = calibrate(folder.path(), "my.toml", "machine.json", &[]);
        assert_eq!(output.status.code(), Some(2), "{to}: {}", said(&output));
        assert!(said(&output).contains(words), "'{words}' is missing in: {}", said(&output));
        assert!(!at("machine.json").exists() && output.stdout.is_empty());
    }
    // without the autocollimator and the midline, straightness and yaw stand in for each other
    let sets: Vec<&str> = text.split("[[readings]]").collect();
    let alone = format!("{}[[readings]]{}", sets[0].replace("\"ezz\", ", ""), sets[3]);
    std::fs::write(at("my.toml"), alone).unwrap();
    let output = calibrate(folder.path(), "my.toml", "machine.json", &[]);
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    let shown = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(shown.contains("EXZ") && shown.contains("cannot be separated"), "{shown}");
    assert!(at("machine.json").exists());
    let output = shadowgauge(["calibrate", "machine", "my.toml", "--out", "machine.txt"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("must end in .json"), "{}", said(&output));
}
