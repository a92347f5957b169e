//! The examples as cargo built them beside this test: each runs to its end and prints what it is
//! for.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::path::PathBuf;
use std::process::Command;

/// An example, its arguments, and words that its stdout must hold. `OUT` in an argument is a
/// folder of the test's own.
type Row = (&'static str, &'static [&'static str], &'static [&'static str]);

const EXAMPLES: &[Row] = &[
    ("calibrate_two_pins", &[], &["scale        30.", "edge offset", "part         11."]),
    ("render_with_truth", &["OUT/frame.png", "8.0"], &["512 x 400 px", "true pixel size", "8.00"]),
    ("live_plot", &["14"], &["    0  11.99", "   13  12.00", "|   ", "  out"]),
    ("measure_image", &["OUT/frame.png", "30"], &["D = ", " mm (k = "]),
    ("frame_source", &[], &[" mm"]),
    ("closed_loop", &[], &["pass 1"]),
    ("own_controller", &[], &["pass 1", "mean error"]),
];

/// The folder of the built examples: `target/PROFILE/examples`, beside `deps` with this test.
fn folder() -> PathBuf {
    let test = std::env::current_exe().expect("this test's own file");
    test.parent().and_then(|deps| deps.parent()).expect("target/PROFILE/deps").join("examples")
}

#[test]
fn every_example_runs_and_prints_what_it_is_for() {
    let out = tempfile::tempdir().expect("a folder");
    for (name, arguments, words) in EXAMPLES {
        let program = folder().join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
        let built = program.is_file();
        assert!(built, "{} is absent: cargo build --examples, of the test's profile", program.display());
        let arguments = arguments.iter().map(|a| a.replace("OUT", &out.path().to_string_lossy()));
        let output = Command::new(&program).args(arguments).output().expect("the example starts");
        let (text, errors) =
            (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert!(output.status.success(), "{name}: {}\n{text}{errors}", output.status);
        for word in *words {
            assert!(text.contains(word), "{name}: {word:?} is missing in:\n{text}{errors}");
        }
    }
    let frame = image::open(out.path().join("frame.png")).expect("the frame that was written");
    assert_eq!((frame.width(), frame.height()), (512, 400));
}

#[test]
fn every_example_is_in_the_table() {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples");
    let files = std::fs::read_dir(&root).expect("examples/").map(|entry| entry.unwrap().path());
    for file in files.filter(|file| file.extension().is_some_and(|e| e == "rs")) {
        let name = file.file_stem().unwrap().to_string_lossy().into_owned();
        assert!(EXAMPLES.iter().any(|row| row.0 == name), "{name} has no row in this test");
    }
}
