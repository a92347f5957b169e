//! Every head in `configs/` can be drawn, and measured where one frame shows both edges; the gallery draws all it promises.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::path::{Path, PathBuf};

use assert_cmd::Command;

fn shadowgauge(arguments: &[&str]) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_shadowgauge")).args(arguments).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

fn configs() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
    let mut found: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.file_name().unwrap().to_string_lossy().starts_with("head_"))
        .collect();
    found.sort();
    found
}

/// Rows (top, bottom) of a CSV of edges, both numbers present.
fn edges(path: &Path) -> Vec<(f64, f64)> {
    let text = std::fs::read_to_string(path).unwrap();
    let row = |line: &str| {
        let f: Vec<&str> = line.split(',').collect();
        Some((f.get(2)?.parse().ok()?, f.get(3)?.parse().ok()?))
    };
    text.lines().skip(1).filter_map(row).collect()
}

#[test]
fn every_head_renders_and_is_measured_where_one_frame_shows_both_edges() {
    let folder = tempfile::tempdir().unwrap();
    let heads = configs();
    assert_eq!(heads.len(), 4, "{heads:?}");
    for head in heads {
        let name = head.file_stem().unwrap().to_string_lossy().into_owned();
        let out = folder.path().join(&name);
        let (config, to) = (head.to_str().unwrap(), out.to_str().unwrap());
        let (code, _, stderr) =
            shadowgauge(&["render", config, "--out", to, "--frames", "1", "--backend", "cpu"]);
        assert_eq!(code, 0, "{name}: {stderr}");
        let truth = edges(&out.join("truth.csv"));
        assert!(!truth.is_empty(), "{name}");
        let csv = folder.path().join(format!("{name}.csv"));
        let frames = out.join("frames");
        let (code, _, stderr) =
            shadowgauge(&["measure", frames.to_str().unwrap(), "--edges", csv.to_str().unwrap()]);
        if code != 0 {
            println!("{name}: not measured: {}", stderr.lines().next().unwrap_or_default());
            assert!(name != "head_telecentric_25" && name != "head_wire", "{name}: {stderr}");
            continue;
        }
        let measured = edges(&csv);
        let mean = |v: &[(f64, f64)]| v.iter().map(|e| e.1 - e.0).sum::<f64>() / v.len().max(1) as f64;
        println!(
            "{name}: {} of {} columns, {:.3} px wider than the truth",
            measured.len(),
            truth.len(),
            mean(&measured) - mean(&truth)
        );
    }
}

#[test]
fn edge_heads_deliver_two_windows_with_an_edge_each() {
    let folder = tempfile::tempdir().unwrap();
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/head_edge_pair_50.toml");
    let out = folder.path().join("pair");
    let (code, _, stderr) = shadowgauge(&[
        "render",
        config.to_str().unwrap(),
        "--out",
        out.to_str().unwrap(),
        "--frames",
        "1",
        "--backend",
        "cpu",
    ]);
    assert_eq!(code, 0, "{stderr}");
    for (top, bottom) in edges(&out.join("truth.csv")) {
        assert!((0.0..512.0).contains(&top) && (512.0..1024.0).contains(&bottom), "{top} {bottom}");
        // Rows left out between the windows: 14670 - 178 - 512.
        let diameter_mm = (bottom - top + 13_980.0) * 3.45e-3;
        assert!((diameter_mm - 50.0).abs() < 0.05, "{diameter_mm}");
    }
}

#[test]
fn gallery_draws_every_case_and_a_contact_sheet() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("gallery");
    let to = out.to_str().unwrap();
    let (code, stdout, stderr) = shadowgauge(&["render", "--gallery", to, "--backend", "cpu"]);
    assert_eq!(code, 0, "{stderr}");
    let sheet = std::fs::metadata(out.join("contact_sheet.png")).unwrap().len();
    assert!(sheet <= 400 * 1024, "the contact sheet has {sheet} bytes");
    let frames = std::fs::read_dir(&out)
        .unwrap()
        .filter(|e| e.as_ref().unwrap().path().extension().is_some_and(|x| x == "toml"))
        .count();
    assert!(frames >= 20, "{stdout}: {frames} cases");
    // What the gallery shows can be tried: its configs are configs.
    let again = folder.path().join("again");
    let config = out.join("gaussian.toml");
    let (code, _, stderr) = shadowgauge(&[
        "render",
        config.to_str().unwrap(),
        "--out",
        again.to_str().unwrap(),
        "--backend",
        "cpu",
    ]);
    assert_eq!(code, 0, "{stderr}");
    let (code, _, stderr) = shadowgauge(&["render", "--gallery", to, "--backend", "cpu"]);
    assert!(code == 2 && stderr.contains("not empty"), "{code}: {stderr}");
}
