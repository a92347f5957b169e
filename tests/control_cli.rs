//! Control's commands from outside the binary: stability, reproduction, programs, refusals.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

#[path = "support/program.rs"]
mod program;

#[path = "control_cli/tool.rs"]
mod tool;
#[path = "control_cli/with_command.rs"]
mod with_command;

use program::{said, shadowgauge, text};
use std::path::Path;

#[track_caller]
fn assert_refused(arguments: &[&str], exit: i32, words: &[&str]) {
    let output = shadowgauge(arguments);
    let text = said(&output);
    assert_eq!(output.status.code(), Some(exit), "{arguments:?}: {text}");
    for word in words {
        assert!(text.contains(word), "{arguments:?}: {word:?} is missing in: {text}");
    }
    assert!(!text.contains("panicked"), "{text}");
}

#[test]
fn stability_is_told_for_every_controller() {
    let output = shadowgauge(["study", "stability", "--json"]);
    assert!(output.status.success());
    let study: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let loops = study["loops"].as_array().expect("loops");
    let absolute = loops
        .iter()
        .find(|l| {
            l["controller"].as_str().is_some_and(|c| c.contains("absolute")) && l["plant"] == "error copying"
        })
        .expect("the absolute form");
    assert_eq!(absolute["stable"], false);
    let limit = absolute["stable_gains"][0][1].as_f64().expect("a limit");
    assert!((limit - 0.8599).abs() < 1e-3);
    for name in ["pid", "lsq", "ewma", "dewma", "ilc", "model"] {
        assert!(
            loops.iter().any(|l| l["controller"].as_str().is_some_and(|c| c.starts_with(name))),
            "{name}"
        );
    }
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("study");
    assert!(shadowgauge(["study", "stability", "--out", &out.to_string_lossy()]).status.success());
    for name in ["stability.csv", "stability.svg", "report.html"] {
        assert!(out.join(name).metadata().is_ok_and(|m| m.len() > 500), "{name}");
    }
    assert_refused(&["study", "stability", "--out", &out.to_string_lossy()], 2, &["is not empty"]);
    assert_refused(&["study", "stability", "--gain", "3"], 2, &["control.plant_gain = 3"]);
}

#[test]
fn unstable_gains_are_refused_by_a_run_unless_insisted_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("written");
        path.to_string_lossy().into_owned()
    };
    let absolute = write("absolute.toml", "[control.pid]\nform = \"absolute\"\n");
    let out = folder.path().join("out").to_string_lossy().into_owned();
    let words = ["unstable", "control.plant_gain = 0.95", "0.8602", "insist_on_unstable"];
    assert_refused(&["run", &absolute, "--out", &out, "--backend", "cpu"], 2, &words);
    assert!(!Path::new(&out).exists(), "nothing half-written");
    let steep = write("steep.toml", "[control]\ncontroller = \"ewma\"\n[control.ewma]\nweight = 1.5\n");
    assert_refused(&["run", &steep, "--out", &out], 2, &["control.ewma.weight", "at most 1"]);
    assert_refused(&["study", "controllers", &steep], 2, &["control.ewma.weight"]);
    assert_refused(&["study", "controllers", "--controllers", "pdi"], 2, &["none, pid, lsq"]);
}

#[test]
fn reproduction_of_000_is_computed_when_asked() {
    let rows = |more: &[&str], code: i32| -> Vec<serde_json::Value> {
        let output = shadowgauge([&["reproduce", "000", "--no-frames", "--json"], more].concat());
        assert_eq!(output.status.code(), Some(code), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).expect("JSON rows")
    };
    let find = |rows: &[serde_json::Value], id: &str| {
        rows.iter().find(|r| r["id"] == id).unwrap_or_else(|| panic!("{id}")).clone()
    };
    let plain = rows(&[], 0);
    let ours = |id: &str| find(&plain, id)["ours"].as_f64().expect("a number");
    assert!((ours("eq5.b") - 201.0 / 175.0).abs() < 1e-12 && (ours("eq6.a") - 316.0 / 75.0).abs() < 1e-12);
    assert!((ours("eq9.804") - 4.404_762).abs() < 1e-6 && (ours("eq10.805") - 5.361_905).abs() < 1e-6);
    assert!((ours("experiment.reduction") - 18.5).abs() < 0.05);
    for (id, verdict) in [
        ("eq1", "consistent"),
        ("eq2", "consistent"),
        ("eq3", "consistent"),
        // The errors are reconstructed from the printed a and b.
        ("eq5.b", "consistent"),
        ("eq10.805", "consistent"),
        ("experiment.change", "consistent"),
        // A limit error, whose data are lost: nothing is contradicted by the means.
        ("experiment.reduction", "undetermined"),
        ("experiment.left", "undetermined"),
        ("eq4.quadratic", "undetermined"),
        ("eq7-10.order", "contradiction"),
    ] {
        assert_eq!(find(&plain, id)["verdict"], verdict, "{id}");
    }
    // Newton's second divided difference through x = 1/6, 1/2, 1 of 4.4, 4.8, 5.4: both slopes
    // are 1.2.
    assert!(ours("eq4.quadratic").abs() < 1e-12);
    // Errors that do not yield the printed line are a miss.
    let changed = rows(&["--errors", "4.4,4.6,4.8,5.0,5.1,6.4"], 1);
    assert_eq!(find(&changed, "eq5.b")["verdict"], "not_reproduced");
    assert!((find(&changed, "eq5.b")["ours"].as_f64().expect("b") - ours("eq5.b")).abs() > 0.5);
    assert_refused(&["reproduce", "000", "--errors", "1,2,3"], 2, &["six finite errors", "3 were given"]);
    assert_refused(&["reproduce", "000", "--unit-mm", "0"], 2, &["positive"]);
}

#[test]
fn reproduction_of_004_prints_rows_and_fills_a_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("004");
    let rows = |more: &[&str]| -> Vec<serde_json::Value> {
        let output = shadowgauge([&["reproduce", "004", "--json"], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).expect("JSON rows")
    };
    let verdict = |rows: &[serde_json::Value], id: &str| {
        rows.iter().find(|r| r["id"] == id).unwrap_or_else(|| panic!("{id}"))["verdict"].clone()
    };
    let plain = rows(&["--out", &out.to_string_lossy()]);
    assert_eq!(verdict(&plain, "nose.r"), "consistent");
    assert_eq!(verdict(&plain, "c01.part1.dz"), "undetermined");
    assert_eq!(verdict(&plain, "c07.radius"), "contradiction");
    for name in ["report.html", "rows.csv", "e_of_a.svg", "workpieces.svg"] {
        assert!(out.join(name).metadata().is_ok_and(|m| m.len() > 1000), "{name}");
    }
    let csv = std::fs::read_to_string(out.join("rows.csv")).expect("rows");
    assert_eq!(csv.lines().count(), plain.len() + 1);
    // every row stands in one table of the page
    let page = std::fs::read_to_string(out.join("report.html")).expect("the page");
    for row in &plain {
        let id = row["id"].as_str().expect("an id");
        assert_eq!(page.matches(&format!(">{id}: ")).count(), 1, "{id}");
    }
    let stated = rows(&["--cone-deg", "24,37.6"]);
    assert_eq!(verdict(&stated, "c01.part1.dz"), "consistent");
    let text = shadowgauge(["reproduce", "004"]);
    assert!(String::from_utf8_lossy(&text.stdout).contains(&format!("{} rows: ", plain.len())));
    assert_refused(&["reproduce", "004", "--cone-deg", "24"], 2, &["two half angles", "1 given"]);
    assert_refused(&["reproduce", "004", "--cone-deg", "24,95"], 2, &["part 2", "95", "1 to 89"]);
    assert_refused(&["reproduce", "004", "--out", &out.to_string_lossy()], 2, &["not empty"]);
}

/// A finished run of two passes with a barrel as offset, or a line.
fn run_folder(folder: &Path, offset_mm: impl Fn(f64) -> f64) -> String {
    let run = folder.join("run");
    std::fs::create_dir_all(&run).expect("a folder");
    let config = "# config sha256 0\n[part]\nlength_mm = 500.0\n";
    std::fs::write(run.join("run.toml"), config).expect("written");
    let mut csv = String::from("pass,z_mm,offset_mm,commanded_mm,status,reason\n");
    for (pass, nominal) in [(1, 26.5), (2, 26.0)] {
        for i in 0..100 {
            let z = 2.5 + 5.0 * f64::from(i);
            let o = if pass == 1 { 0.0 } else { offset_mm(z) };
            csv += &format!("{pass},{z},{o},{},released,\n", nominal - o);
        }
    }
    std::fs::write(run.join("offsets.csv"), csv).expect("written");
    run.to_string_lossy().into_owned()
}

/// The machine data that a Fanuc or a GSK requires.
fn stated_machine(folder: &std::path::Path) -> String {
    let file = folder.join("stated.toml");
    let text = "wear_x = \"diameter\"\ngeometry_offset = \"by_tool\"\nspindle = \"M03\"\n";
    std::fs::write(&file, text).expect("written");
    file.to_string_lossy().into_owned()
}

#[test]
fn nc_writes_a_runs_offsets() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = run_folder(folder.path(), |z| 0.05 * (1.0 - (z / 250.0 - 1.0).powi(2)));
    let stated = stated_machine(folder.path());
    let text =
        text(&shadowgauge(["nc", &run, "--dialect", "fanuc", "--part", "17", "--machine", &stated]).stdout);
    assert!(text.contains("PART 17 PASS 2") && text.contains("G10 P16 X-0.033"), "{text}");
    let list = program::text(&shadowgauge(["nc", &run, "--dialect", "gsk", "--dry-run"]).stdout);
    assert!(list.contains("reason: released") && list.contains("old/mm"), "{list}");
    let file = folder.path().join("pass2.ngc").to_string_lossy().into_owned();
    assert!(shadowgauge(["nc", &run, "--dialect", "linuxcnc", "--out", &file]).status.success());
    assert!(std::fs::read_to_string(&file).is_ok_and(|t| t.ends_with("%\n")));
    assert_refused(&["nc", &run, "--dialect", "fanuc", "--pass", "9"], 2, &["no pass 9", "1 to 2"]);
    assert_refused(&["nc", &run, "--dialect", "heidenhain"], 2, &["fanuc, linuxcnc, gsk"]);
    assert_refused(
        &["nc", &run, "--dialect", "gsk", "--form", "macro"],
        2,
        &["a line leaves", "--form knots"],
    );
    let machine = folder.path().join("machine.toml").to_string_lossy().into_owned();
    std::fs::write(&machine, "tool = 3\nwear = 1\n").expect("written");
    assert_refused(&["nc", &run, "--dialect", "gsk", "--machine", &machine], 2, &["unknown field", "wear"]);
    let nowhere = folder.path().join("nowhere").to_string_lossy().into_owned();
    assert_refused(&["nc", &nowhere, "--dialect", "gsk"], 3, &["no run folder"]);
}

#[test]
fn nc_writes_a_line_as_macro_program() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = run_folder(folder.path(), |z| 0.03 + 0.02 * (500.0 - z) / 500.0);
    let stated = stated_machine(folder.path());
    let text = text(
        &shadowgauge(["nc", &run, "--dialect", "fanuc", "--form", "macro", "--machine", &stated]).stdout,
    );
    assert!(text.contains("#802=0.02\n") && text.contains("#803=0.03\n"), "{text}");
    let list = program::text(
        &shadowgauge(["nc", &run, "--dialect", "fanuc", "--form", "macro", "--dry-run"]).stdout,
    );
    assert!(list.contains("#805 = 0.050000"), "{list}");
}

/// A stepped shaft of another size and material: the study turns this shaft, and the model-based
/// controller takes all it assumes from the job.
const STEPPED_ALUMINIUM: &str = "
name = \"aluminium\"
[part]
length_mm = 120.0
stock_diameter_mm = 64.8
nominal_diameter_mm = [63.2, 61.6, 60.0]
station_mm = 4.0
[[part.sections]]
z_mm = 100.0
tolerance = \"40 h7\"
[shaft]
contour = [
    { z_mm = 0.0, diameter_mm = 60.0 },
    { z_mm = 40.0, diameter_mm = 60.0 },
    { z_mm = 40.0, diameter_mm = 50.0 },
    { z_mm = 80.0, diameter_mm = 50.0 },
    { z_mm = 80.0, diameter_mm = 40.0 },
    { z_mm = 120.0, diameter_mm = 40.0 },
]
[cutting]
speed_m_per_min = 200.0
feed_mm_per_rev = 0.2
[process.material]
name = \"EN AW-6082\"
[process.force.kienzle]
kc11_n_per_mm2 = 700.0
mc = 0.25
[process.support]
chuck_n_per_um = 2.0
tailstock_n_per_um = 0.5
[scan]
fields = 4
angles = 4
[masters]
frames_each = 4
[[masters.pins]]
diameter_mm = 39.0
expanded_u_mm = 0.0002
[[masters.pins]]
diameter_mm = 65.0
expanded_u_mm = 0.0002
[camera]
columns = 400
rows = 800
pixel_um = 3.45
[optics]
magnification = 0.0345
[control.guards]
outlier_limit_mm = 0.02
scatter_limit_mm = 0.02
";

#[test]
fn a_stepped_shaft_of_another_size_and_material_is_what_the_study_turns() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("aluminium.toml");
    std::fs::write(&path, STEPPED_ALUMINIUM).expect("written");
    let output = shadowgauge([
        "study",
        "controllers",
        &path.to_string_lossy(),
        "--shafts",
        "1",
        "--controllers",
        "pid,lsq,model",
        "--backend",
        "cpu",
        "--json",
    ]);
    assert!(output.status.success(), "{}", said(&output));
    let study: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let um = |controller: &str, pass: usize| {
        let all = study["controllers"].as_array().expect("controllers");
        let own = all.iter().find(|c| c["controller"] == controller).expect("a controller");
        own["passes"][pass]["mean_mm"].as_f64().expect("a number") * 1e3
    };
    let errors = |name: &str| [0, 1, 2].map(|pass| um(name, pass));
    println!("{:?}", ["none", "pid", "lsq", "model"].map(|name| (name, errors(name))));
    for name in ["pid", "lsq", "model"] {
        assert!((um(name, 0) - um("none", 0)).abs() < 1e-9, "pass 1 is independent of the controller");
        assert!(um(name, 2) < 0.3 * um("none", 2), "{name}: {} of {}", um(name, 2), um("none", 2));
    }
    // The shaft cut with these supports, and not the preset's, yields by this much.
    assert!((5.0..50.0).contains(&um("none", 0)), "{}", um("none", 0));
    // The config is checked as a run checks it.
    let text = STEPPED_ALUMINIUM.replace("z_mm = 100.0", "z_mm = 80.0");
    std::fs::write(&path, text).expect("written");
    assert_refused(
        &["study", "controllers", &path.to_string_lossy(), "--shafts", "1"],
        2,
        &["part.sections[0].z_mm", "no section is there"],
    );
}
