//! From images to offsets, from outside: a first part, the trial cut, released offsets and their
//! programs; wrong signs and units, images that come twice, states of other jobs.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

#[path = "support/program.rs"]
mod program;

use program::{json, said, shadowgauge, text};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Output;

/// A lathe whose part is measured after its only pass.
const JOB: &str = concat!(
    r#"
name = "small"
seed = 5
[part]
length_mm = 60.0
stock_diameter_mm = 11.5
nominal_diameter_mm = [11.0]
station_mm = 10.0
[part.tolerance]
nominal_mm = 11.0
upper_mm = 0.01
lower_mm = -0.01
[control]
controller = "ewma"
"#,
    include_str!("support/small_view.toml")
);
/// Share of a command that the lathe follows: it yields.
const GAIN: f64 = 0.96;
/// What a part without offsets has too much, mm.
const ERROR_MM: f64 = 0.006;

struct Lathe {
    folder: tempfile::TempDir,
}

impl Lathe {
    /// A camera that was calibrated on its masters.
    fn new() -> Self {
        let lathe = Self { folder: tempfile::tempdir().unwrap() };
        lathe.write("job.toml", JOB);
        let (job, out) = (lathe.path("job.toml"), lathe.path("calibrated"));
        let output = shadowgauge([
            "run",
            &job,
            "--out",
            &out,
            "--backend",
            "cpu",
            "--no-reference",
            "--controller",
            "none",
        ]);
        assert!(matches!(output.status.code(), Some(0 | 1)), "{}", said(&output));
        lathe
    }

    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).to_string_lossy().into_owned()
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    /// Frames of a part with this diameter.
    fn part(&self, name: &str, d_mm: f64) -> String {
        let text = JOB.replace("nominal_diameter_mm = [11.0]", &format!("nominal_diameter_mm = [{d_mm}]"));
        let config = self.write(&format!("{name}.toml"), &text.replace("= 11.5", "= 12.0"));
        let out = self.path(name);
        let output = shadowgauge(["render", &config.to_string_lossy(), "--out", &out, "--backend", "cpu"]);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        out
    }

    /// The decision on a part.
    fn offsets(&self, frames: &str, more: &[&str]) -> Output {
        let (job, state) = (self.path("job.toml"), self.path("state.toml"));
        let calibration = self.path("calibrated/calibration.json");
        let fixed = [
            "measure",
            frames,
            "--calibration",
            &calibration,
            "--offsets",
            &job,
            "--state",
            &state,
            "--json",
        ];
        shadowgauge([&fixed[..], more].concat())
    }

    /// Frames of the first part, and the state after it.
    fn after_first_part(&self) -> Value {
        let first = self.part("first", 11.0 + ERROR_MM);
        let output = self.offsets(&first, &["--part", "A1", "--tool", "T1", "--insert", "I1"]);
        let found = json(&output)["offsets"].clone();
        assert_eq!(
            (output.status.code(), &found["outcome"]),
            (Some(0), &Value::from("first_use")),
            "{found:#}"
        );
        found
    }

    fn state(&self) -> toml::Table {
        std::fs::read_to_string(self.path("state.toml")).unwrap().parse().unwrap()
    }
}

fn new_um(offsets: &Value) -> Vec<f64> {
    let stations = offsets["stations"].as_array().unwrap();
    stations.iter().map(|s| 1e3 * s["new_offset_mm"].as_f64().unwrap()).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[test]
fn a_trial_cut_proves_sign_and_unit_and_then_parts_converge() {
    let lathe = Lathe::new();
    let first = lathe.after_first_part();
    // larger, never smaller: o = -50 µm
    assert!(new_um(&first).iter().all(|o| (o + 50.0).abs() < 1e-9), "{first:#}");
    assert!(first["reason"].as_str().unwrap().contains("cut air"), "{first:#}");
    assert_eq!(lathe.state()["stage"].as_str(), Some("trial"));

    let trial = lathe.part("trial", 11.0 + ERROR_MM + GAIN * 0.05);
    let output = lathe.offsets(&trial, &["--part", "A1"]);
    let found = json(&output)["offsets"].clone();
    assert_eq!(found["outcome"], "released", "{found:#}");
    let ratio = found["observed_over_commanded"].as_f64().unwrap();
    assert!((ratio - GAIN).abs() < 0.02, "{ratio}");
    // the controller corrects what the part had too much, not the 50 µm left on purpose
    let o_um = mean(&new_um(&found));
    assert!((2.0..8.0).contains(&o_um), "{o_um} {found:#}");

    let second = lathe.part("second", 11.0 + ERROR_MM - GAIN * 1e-3 * o_um);
    let output = lathe.offsets(&second, &["--part", "A2"]);
    let found = json(&output)["offsets"].clone();
    assert_eq!((output.status.code(), &found["outcome"]), (Some(0), &Value::from("released")), "{found:#}");
    assert!((mean(&new_um(&found)) - ERROR_MM * 1e3 / GAIN).abs() < 1.5, "{found:#}");
    assert_eq!(found["stations"][2]["judgement"], "conforms");
    assert_eq!(found["labels"]["part"], "A2");

    // the same images move nothing, in another order and under other names neither
    let again = lathe.offsets(&second, &[]);
    let held = json(&again)["offsets"].clone();
    assert_eq!((again.status.code(), &held["outcome"]), (Some(1), &Value::from("held")), "{held:#}");
    assert!(held["reason"].as_str().unwrap().contains("used once"), "{held:#}");
    assert_eq!(new_um(&held), new_um(&found));
    let copy = lathe.path("copy");
    std::fs::create_dir(&copy).unwrap();
    std::fs::copy(Path::new(&second).join("frames/000003.png"), Path::new(&copy).join("000000.png")).unwrap();
    std::fs::write(Path::new(&copy).join("frames.csv"), "frame,z_mm,angle_deg\n000000,30,0\n").unwrap();
    let held = json(&lathe.offsets(&copy, &[]))["offsets"].clone();
    assert!(held["reason"].as_str().unwrap().contains("used once"), "{held:#}");

    programs(&lathe);
    resets(&lathe, &second, &new_um(&found));
}

/// Programs of the next part in every dialect, its air cut and the list.
fn programs(lathe: &Lathe) {
    let machine = lathe.write(
        "machine.toml",
        "wear_x = \"diameter\"\ngeometry_offset = \"by_tool\"\nspindle = \"M03\"\ntailstock = \"none\"\n",
    );
    let (job, state) = (lathe.path("job.toml"), lathe.path("state.toml"));
    let machine = machine.to_string_lossy().into_owned();
    for dialect in ["fanuc", "linuxcnc", "gsk", "sinumerik"] {
        let nc = |more: &[&str]| {
            let fixed = ["nc", &job, "--state", &state, "--dialect", dialect, "--machine", &machine];
            let output = shadowgauge([&fixed[..], more].concat());
            assert_eq!(output.status.code(), Some(0), "{dialect}: {}", said(&output));
            text(&output.stdout)
        };
        let (cut, air) = (nc(&[]), nc(&["--air"]));
        assert!(cut.contains("OFFSETS AFTER MEASUREMENT 3") && cut.contains("PART 4 PASS 1"), "{cut}");
        assert!(air.contains("AIR CUT OF PASS 1") && air != cut, "{air}");
    }
}

/// A worn insert's offsets do not hold for a new one, a tool's not for another tool.
fn resets(lathe: &Lathe, images: &str, before_um: &[f64]) {
    let output = lathe.offsets(images, &["--insert", "I2"]);
    let found = json(&output)["offsets"].clone();
    assert_eq!((output.status.code(), &found["outcome"]), (Some(0), &Value::from("reset")), "{found:#}");
    let notes = found["notes"].to_string();
    assert!(notes.contains("new edge cuts deeper") && notes.contains("Kept: proof"), "{found:#}");
    let kept = new_um(&found);
    assert!(kept.iter().zip(before_um).all(|(now, before)| now <= before), "{kept:?} {before_um:?}");
    assert_eq!(lathe.state()["stage"].as_str(), Some("released"));
    let found = json(&lathe.offsets(images, &["--tool", "T2"]))["offsets"].clone();
    assert!(found["notes"].to_string().contains("proof of sign and unit"), "{found:#}");
    assert!(new_um(&found).iter().all(|o| *o == 0.0), "{found:#}");
    assert_eq!(lathe.state()["stage"].as_str(), Some("first"));
}

#[test]
fn a_wrong_sign_or_unit_is_refused_with_its_cause() {
    let lathe = Lathe::new();
    lathe.after_first_part();
    let kept = std::fs::read(lathe.path("state.toml")).unwrap();
    for (name, change_mm, word) in [
        ("sign", -0.05, "the sign is wrong"),
        ("twice", 0.1, "a diameter is taken as a radius"),
        ("half", 0.025, "a radius is taken as a diameter"),
        ("nothing", 0.0003, "no effect"),
        // 1.27 mm or 50 mm more: the tool stays above the blank of 11.5 mm
        ("inches", 0.5 - ERROR_MM, "nothing was cut"),
    ] {
        std::fs::write(lathe.path("state.toml"), &kept).unwrap();
        let frames = lathe.part(name, 11.0 + ERROR_MM + GAIN.powi(i32::from(change_mm < 0.2)) * change_mm);
        let output = lathe.offsets(&frames, &[]);
        let found = json(&output)["offsets"].clone();
        assert_eq!(
            (output.status.code(), &found["outcome"]),
            (Some(1), &Value::from("refused")),
            "{found:#}"
        );
        let why = found["reason"].as_str().unwrap();
        assert!(why.contains(word), "{name}: {why}");
        // no offset is released: the trial's are still in force
        assert!(new_um(&found).iter().all(|o| (o + 50.0).abs() < 1e-9), "{found:#}");
        assert_eq!(lathe.state()["stage"].as_str(), Some("trial"));
    }
}

#[test]
fn what_does_not_belong_together_is_refused_by_name() {
    let lathe = Lathe::new();
    lathe.after_first_part();
    let frames = lathe.path("first");
    let kept = std::fs::read(lathe.path("state.toml")).unwrap();
    lathe.write("job.toml", &JOB.replace("name = \"small\"", "name = \"another\""));
    let output = lathe.offsets(&frames, &[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        said(&output).contains("job \"small\"") && said(&output).contains("another"),
        "{}",
        said(&output)
    );
    lathe.write("job.toml", &JOB.replace("station_mm = 10.0", "station_mm = 5.0"));
    let output = lathe.offsets(&frames, &[]);
    assert!(output.status.code() == Some(2) && said(&output).contains("stations"), "{}", said(&output));
    assert_eq!(std::fs::read(lathe.path("state.toml")).unwrap(), kept, "the state stays as it was");
    lathe.write("job.toml", &JOB.replace("\"ewma\"", "\"model\""));
    let output = lathe.offsets(&frames, &["--pass", "1"]);
    assert!(matches!(output.status.code(), Some(1 | 2)), "{}", said(&output));
    // without places every frame would stand at z = 0
    std::fs::remove_file(Path::new(&frames).join("frames.csv")).unwrap();
    lathe.write("job.toml", JOB);
    let output = lathe.offsets(&frames, &[]);
    assert_eq!(output.status.code(), Some(3));
    assert!(said(&output).contains("z_mm"), "{}", said(&output));
    let job = lathe.path("job.toml");
    let output = shadowgauge(["measure", &frames, "--um-per-px", "30", "--offsets", &job]);
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("--calibration"), "{}", said(&output));
}
