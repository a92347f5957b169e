//! The instrument without its features in somebody else's crate (`tests/beside`): a cell, a
//! controller and a source of frames of its own, 200 of which give the bytes of the command line.
//!
//! That the crate compiles against the instrument alone is checked in a manifest of its own; its
//! program runs as cargo built it as an example of this crate: a second build of the instrument
//! took four minutes and gave the same bytes.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

#[path = "support/drawn_frames.rs"]
mod drawn_frames;
#[path = "support/program.rs"]
mod program;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// The crate's manifest in a folder of its own, its paths made absolute, with this crate's lock
/// file beside it: the versions tested are those locked, and none is fetched.
fn manifest() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("beside");
    let text = std::fs::read_to_string(Path::new(ROOT).join("tests/beside/Cargo.toml")).unwrap();
    let absolute = text.replace("../..", ROOT).replace("\"src/", &format!("\"{ROOT}/tests/beside/src/"));
    assert_eq!(absolute.matches(ROOT).count(), 3, "two programs and this crate: {absolute}");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("Cargo.toml"), absolute).unwrap();
    std::fs::copy(Path::new(ROOT).join("Cargo.lock"), folder.join("Cargo.lock")).unwrap();
    folder.join("Cargo.toml")
}

/// The folder of this test's profile: `target/PROFILE`, with this test in `deps`.
fn profile_folder() -> PathBuf {
    let test = std::env::current_exe().expect("this test's own file");
    test.parent().and_then(|deps| deps.parent()).expect("target/PROFILE/deps").to_owned()
}

fn cargo(manifest: &Path) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    // Dependencies that the linter has checked with the same features are not checked again.
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().expect("target/tmp lies in target");
    command.env("CARGO_TARGET_DIR", target).env("CARGO_NET_OFFLINE", "true");
    command.env_remove("CARGO_BUILD_TARGET").current_dir(manifest.parent().unwrap());
    command
}

/// Output of a command that must succeed without a warning.
fn stdout(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|e| panic!("{command:?}: {e}"));
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (out, errors) = (text(&output.stdout), text(&output.stderr));
    assert!(output.status.success() && !errors.contains("warning"), "{command:?}: {out}{errors}");
    out
}

/// A loop that its own controller closes: the first pass shows the lathe's 30 µm, the last one lies
/// within the tolerance of 10 µm, and the measurement follows the part throughout.
fn judge_passes(passes: &Value) {
    let passes = passes.as_array().expect("passes");
    assert_eq!(passes.len(), 3, "{passes:?}");
    let figure = |pass: usize, key: &str| passes[pass][key].as_f64().expect(key);
    for pass in 0..3 {
        assert_eq!(passes[pass]["valid"], passes[pass]["stations"], "{passes:?}");
        // four fields at four angles
        assert_eq!((&passes[pass]["frames"], &passes[pass]["refused"]), (&16.into(), &Value::Array(vec![])));
        // 10 counts of noise in 2900 over 67 columns leave below 0.1 µm; the certificates 0.05 µm
        assert!(figure(pass, "measured_minus_true_mm") < 1e-3, "{passes:?}");
    }
    assert!((0.025..0.035).contains(&figure(0, "max_abs_error_mm")), "{passes:?}");
    assert!(figure(2, "max_abs_error_mm") < 0.005, "{passes:?}");
}

/// The document of the same frames as files, as the program prints it.
fn judge_series(document: &str) {
    let folder = tempfile::tempdir().unwrap();
    for frame in 0..drawn_frames::FRAMES {
        let (columns, rows) = (drawn_frames::COLUMNS as u32, drawn_frames::ROWS as u32);
        let image = image::GrayImage::from_raw(columns, rows, drawn_frames::counts(frame)).unwrap();
        image.save(folder.path().join(format!("{frame:06}.png"))).unwrap();
    }
    let (input, scale) = (folder.path().to_string_lossy(), drawn_frames::UM_PER_PX.to_string());
    let printed = program::shadowgauge(["measure", &input, "--json", "--um-per-px", &scale]);
    assert!(document == program::text(&printed.stdout), "{document}");
}

/// What the instrument pulls in: nothing of the simulator, of the program, of reports.
fn judge_tree(text: &str) {
    let names: Vec<&str> = text.lines().filter_map(|line| line.split(' ').next()).collect();
    assert!(names.contains(&"shadowgauge") && names.contains(&"nalgebra"), "{text}");
    for name in [
        "wgpu",
        "naga",
        "clap",
        "plotters",
        "parquet",
        "indicatif",
        "miette",
        "toml",
        "viva-genicam",
        "tokio",
    ] {
        assert!(!names.contains(&name), "{name} is pulled in:\n{text}");
    }
}

#[test]
fn the_instrument_serves_a_crate_beside_it() {
    let manifest = manifest();
    let tree = ["tree", "--offline", "--edges", "normal", "--prefix", "none", "--format", "{p}"];
    judge_tree(&stdout(cargo(&manifest).args(tree)));

    let profile: &[&str] = if cfg!(debug_assertions) { &[] } else { &["--release"] };
    let start = std::time::Instant::now();
    stdout(cargo(&manifest).args(["check", "--offline"]).args(profile));
    println!("checked in {:.1} s", start.elapsed().as_secs_f64());

    let program = profile_folder().join("examples").join(format!("beside{}", std::env::consts::EXE_SUFFIX));
    assert!(
        program.is_file(),
        "{} is absent: cargo build --examples, of the test's profile",
        program.display()
    );
    let found: Value = serde_json::from_str(&stdout(&mut Command::new(&program))).unwrap();
    judge_passes(&found["passes"]);
    judge_series(&stdout(Command::new(&program).arg("frames")));
}
