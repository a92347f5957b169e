//! `measure` from outside: files that are not frames, and frames without a part, give one clear
//! error and no diameter.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use image::{GrayImage, ImageBuffer, Luma, Rgb};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use tempfile::TempDir;

fn measure(args: &[&Path]) -> Output {
    let binary = env!("CARGO_BIN_EXE_shadowgauge");
    Command::new(binary).arg("measure").args(args).env("NO_COLOR", "1").output().expect("the binary runs")
}

/// Exit 3, nothing on stdout, and a message that names the file (or frame) and contains `word`.
fn refused(folder: &TempDir, name: &str, word: &str) {
    let path = folder.path().join(name);
    let output = measure(&[&path, Path::new("--json")]);
    let text: String =
        String::from_utf8_lossy(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
    assert_eq!(output.status.code(), Some(3), "{name}: {text}");
    assert!(output.stdout.is_empty(), "{name}");
    let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
    assert!(text.contains(&stem) && text.contains(word), "{name}: {text}");
    assert!(!text.contains("panicked"), "{name}: {text}");
}

fn save(folder: &TempDir, name: &str, width: u32, height: u32, grey: impl FnMut(u32, u32) -> u8) -> PathBuf {
    let mut grey = grey;
    let path = folder.path().join(name);
    GrayImage::from_fn(width, height, |x, y| Luma([grey(x, y)])).save(&path).unwrap();
    path
}

/// A shadow between rows 60 and 140 with a soft edge.
fn shadow(y: u32) -> u8 {
    let soft = |d: f64| 30.0 + 170.0 / (1.0 + (-2.0 * d).exp());
    let y = f64::from(y);
    if y < 100.0 { soft(60.2 - y) as u8 } else { soft(y - 140.3) as u8 }
}

#[test]
fn frames_without_a_part_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut rng = Pcg64::seed_from_u64(1);
    save(&folder, "black.png", 320, 200, |_, _| 0);
    save(&folder, "white.png", 320, 200, |_, _| 255);
    save(&folder, "ramp.png", 320, 200, |x, _| (x / 2) as u8);
    save(&folder, "uniform.png", 320, 200, |_, _| rng.random());
    let mut rng = Pcg64::seed_from_u64(2);
    save(&folder, "gauss.png", 320, 200, |_, _| {
        (0..12).map(|_| rng.random::<u8>() as u32).sum::<u32>().div_ceil(12) as u8
    });
    let mut rng = Pcg64::seed_from_u64(3);
    save(&folder, "salt.png", 320, 200, |_, _| if rng.random::<bool>() { 255 } else { 0 });
    save(&folder, "dot.png", 1, 1, |_, _| 9);
    save(&folder, "half.png", 320, 200, |_, y| if y < 100 { 200 } else { 20 });
    for (name, word) in [
        ("black.png", "low_contrast"),
        ("white.png", "low_contrast"),
        ("ramp.png", ""),
        ("uniform.png", ""),
        ("gauss.png", ""),
        ("salt.png", ""),
        ("dot.png", "1 rows x 1 columns"),
        ("half.png", "one_edge"),
    ] {
        refused(&folder, name, word);
    }
}

#[test]
fn coarse_noise_gives_no_diameter() {
    // Blobs up to the size of the smallest part: the hardest noise, since it has edges.
    for (seed, cell) in [(1, 2), (2, 4), (3, 8), (4, 16), (5, 24), (6, 5), (7, 12)] {
        let folder = tempfile::tempdir().unwrap();
        let mut rng = Pcg64::seed_from_u64(seed);
        let cells: Vec<bool> = (0..400 * 400).map(|_| rng.random()).collect();
        save(&folder, "blobs.png", 400, 300, |x, y| {
            if cells[(y / cell * 400 + x / cell) as usize] { 220 } else { 20 }
        });
        refused(&folder, "blobs.png", "");
    }
}

#[test]
fn what_is_no_grey_image_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    ImageBuffer::from_fn(64, 64, |x, _| Rgb([x as u8, 0, 0])).save(at("colour.png")).unwrap();
    let whole = save(&folder, "whole.png", 320, 200, |_, y| shadow(y));
    let bytes = std::fs::read(whole).unwrap();
    std::fs::write(at("truncated.png"), &bytes[..bytes.len() / 2]).unwrap();
    std::fs::write(at("empty.png"), []).unwrap();
    std::fs::write(at("text.png"), "not an image").unwrap();
    refused(&folder, "colour.png", "grey");
    refused(&folder, "truncated.png", "truncated");
    refused(&folder, "empty.png", "empty");
    refused(&folder, "text.png", "not an image");
    refused(&folder, "absent.png", "No such file");
    refused(&tempfile::Builder::new().prefix("void").tempdir().unwrap(), ".", "");
}

#[test]
fn a_folder_with_some_bad_frames_gives_gaps_and_good_ones_values() {
    let folder = tempfile::tempdir().unwrap();
    let mut rng = Pcg64::seed_from_u64(4);
    save(&folder, "a.png", 320, 200, |_, y| shadow(y) + rng.random_range(0..5));
    save(&folder, "b.png", 320, 200, |_, _| 255);
    std::fs::write(folder.path().join("c.png"), "not an image").unwrap();
    let csv = folder.path().join("edges.csv");
    let output = measure(&[folder.path(), Path::new("--json"), Path::new("--edges"), &csv]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let frames = json["frames"].as_array().unwrap();
    assert_eq!(frames.len(), 3);
    assert!((frames[0]["max_diameter_px"].as_f64().unwrap() - 80.1).abs() < 0.3, "{}", frames[0]);
    assert_eq!(frames[1]["valid"], 0);
    assert!(frames[1]["max_diameter_px"].is_null() && frames[2]["max_diameter_px"].is_null());
    assert_eq!(frames[2]["flags"]["unreadable"], 1);
    let text = std::fs::read_to_string(&csv).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("frame,column,top_px,bottom_px,u_top_px,u_bottom_px,flag"));
    assert_eq!(text.lines().filter(|l| l.starts_with("a,")).count(), 320);
    assert!(text.lines().any(|l| l == "b,0,,,,,low_contrast"), "{text}");
}

/// A tolerance is judged by every size that a frame gives: a taper's ends, a frame and a place that
/// could not be measured.
#[test]
fn good_is_what_is_proven_everywhere() {
    let folder = tempfile::tempdir().unwrap();
    let mut rng = Pcg64::seed_from_u64(5);
    let soft = |d: f64| 30.0 + 170.0 / (1.0 + (-2.0 * d).exp());
    let mut noisy = |y: u32, bottom: f64| {
        let y = f64::from(y);
        (if y < 100.0 { soft(60.2 - y) } else { soft(y - bottom) }) as u8 + rng.random_range(0..3)
    };
    save(&folder, "even.png", 320, 200, |_, y| noisy(y, 140.3));
    save(&folder, "taper.png", 320, 200, |x, y| noisy(y, 138.7 + f64::from(x) / 100.0));
    save(&folder, "gap.png", 320, 200, |x, y| if (120..200).contains(&x) { 200 } else { noisy(y, 140.3) });
    save(&folder, "blank.png", 320, 200, |_, _| 255);
    let judged = |names: &[&str], more: &[&str]| {
        let paths: Vec<PathBuf> = names.iter().map(|name| folder.path().join(name)).collect();
        let scale = ["--um-per-px", "100", "--tolerance", "7.85..8.1", "--json"];
        let all = scale.iter().chain(more).map(Path::new).chain(paths.iter().map(PathBuf::as_path));
        let output = measure(&all.collect::<Vec<_>>());
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        (output.status.code(), json["frames"].clone())
    };
    let (code, frames) = judged(&["even.png"], &[]);
    assert_eq!((code, &frames[0]["judgement"]), (Some(0), &"GO".into()), "{frames}");
    // Its mean of 8.01 mm is well inside, its ends are not.
    let (code, frames) = judged(&["taper.png"], &[]);
    assert_eq!((code, &frames[0]["judgement"]), (Some(1), &"HH".into()), "{frames}");
    let mean_mm = frames[0]["mean_diameter_mm"].as_f64().unwrap();
    assert!((7.95..8.05).contains(&mean_mm), "{mean_mm}");
    assert!(frames[0]["judged"]["d_mm"].as_f64().unwrap() > 8.1, "{frames}");
    let (code, frames) = judged(&["taper.png"], &["--station-mm", "2"]);
    assert_eq!(code, Some(1));
    assert_eq!(frames[0]["stations"][15]["judgement"], "HH", "{frames}");
    for (name, flag) in [("blank.png", None), ("gap.png", Some("local"))] {
        let (code, frames) = judged(&["even.png", name], &[]);
        assert_eq!((code, &frames[0]["judgement"]), (Some(1), &"GO".into()), "{frames}");
        assert!(frames[1].as_object().unwrap()["judgement"].is_null(), "{frames}");
        assert_eq!(frames[1]["judged"]["what"].as_str(), flag, "{frames}");
    }
}

#[test]
fn the_command_line_and_calibrations_are_checked() {
    let folder = tempfile::tempdir().unwrap();
    let good = save(&folder, "a.png", 320, 200, |_, y| shadow(y));
    let refuse = |args: &[&str], code: i32| {
        let mut all: Vec<&Path> = vec![&good];
        all.extend(args.iter().map(Path::new));
        let output = measure(&all);
        assert_eq!(output.status.code(), Some(code), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
        assert!(output.stdout.is_empty());
    };
    refuse(&["--um-per-px", "0"], 2);
    refuse(&["--um-per-px", "-3"], 2);
    refuse(&["--um-per-px", "NaN"], 2);
    refuse(&["--bench", "0"], 2);
    refuse(&["--threads", "0"], 2);
    refuse(&["--unknown"], 2);
    refuse(&["--calibration", "/nonexistent/calibration.json"], 3);
    let broken = folder.path().join("calibration.json");
    std::fs::write(&broken, "{\"version\": 1}").unwrap();
    refuse(&["--calibration", &broken.to_string_lossy()], 3);
    refuse(&["--edges", "/nonexistent/edges.csv"], 3);
}

#[test]
fn a_bench_reports_its_times_and_beside_what_threads_gain_what_the_machine_gives() {
    let folder = tempfile::tempdir().unwrap();
    let frame = save(&folder, "a.png", 320, 200, |x, y| shadow(y).saturating_add((x * 7 % 5) as u8));
    for threads in ["1", "2"] {
        let args = ["--json", "--bench", "20", "--threads", threads].map(Path::new);
        let output = measure(&[&[frame.as_path()], &args[..]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        let setup = serde_json::from_slice::<serde_json::Value>(&output.stdout).unwrap()["bench"].clone();
        let positive = |key: &str| setup[key].as_f64().is_some_and(|v| v > 0.0);
        assert!(positive("ms_per_frame_median") && positive("first_frame_ms"), "{setup}");
        for key in ["speedup", "speedup_within_a_frame", "speedup_of_independent_streams"] {
            assert_eq!(positive(key), threads == "2", "{setup}");
        }
    }
}
