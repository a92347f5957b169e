//! `measure --esf` and plausibility over turns, from outside the binary.

use serde_json::Value;
use shadowgauge::render::{BackendChoice, Renderer};
use shadowgauge::shaft::Lobe;
use shadowgauge::studies::calibration::SimulatedSetup;

use crate::inside::uncertainty::cli::{PLAN, calibrate, json, laid, path, save, text, true_setup};
use crate::inside::uncertainty::program::shadowgauge;

/// Partially coherent light of a slow lens: far from Gaussian.
const COHERENT: &str = r#"
name = "coherent"
seed = 4
[part]
length_mm = 1.0
stock_diameter_mm = 0.42
nominal_diameter_mm = [0.4]
aim_mm = 0.0
station_mm = 0.5
[scan]
fields = 1
angles = 1
[masters]
frames_each = 1
[[masters.pins]]
diameter_mm = 0.38
expanded_u_mm = 0.0001
[[masters.pins]]
diameter_mm = 0.42
expanded_u_mm = 0.0001
[camera]
columns = 512
rows = 400
pixel_um = 3.45
[optics]
magnification = 2.5
[optics.esf.partially_coherent]
numerical_aperture = 0.1
coherence_ratio = 0.9
wavelength_nm = 525.0
[shaft]
pose = { tilt_mrad = 12.0 }
"#;

/// Rms of the edges' departure from the truth about their mean, and that mean of the widths, px.
fn departure(edges: &str, truth: &str) -> (f64, f64) {
    let rows = |text: &str| -> Vec<(String, [f64; 2])> {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let header = reader.headers().unwrap().clone();
        let at = |name: &str| {
            header.iter().position(|h| h == name).unwrap_or_else(|| panic!("{name} in {header:?}"))
        };
        let (column, top, bottom) = (at("column"), at("top_px"), at("bottom_px"));
        reader
            .records()
            .map(|r| r.unwrap())
            .filter(|r| !r[top].is_empty())
            .map(|r| (r[column].to_owned(), [r[top].parse().unwrap(), r[bottom].parse().unwrap()]))
            .collect()
    };
    let truth: std::collections::HashMap<String, [f64; 2]> = rows(truth).into_iter().collect();
    let errors: Vec<[f64; 2]> = rows(edges)
        .iter()
        .map(|(column, e)| {
            let t = truth[column];
            [e[0] - t[0], e[1] - t[1]]
        })
        .collect();
    assert!(errors.len() > 450, "{}", errors.len());
    let n = errors.len() as f64;
    let mean = |k: usize| errors.iter().map(|e| e[k]).sum::<f64>() / n;
    let (top, bottom) = (mean(0), mean(1));
    let square: f64 = errors.iter().map(|e| (e[0] - top).powi(2) + (e[1] - bottom).powi(2)).sum();
    ((square / (2.0 * n)).sqrt(), bottom - top)
}

#[test]
fn the_edge_spread_function_is_chosen_on_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let config = path(folder.path(), "job.toml");
    std::fs::write(&config, COHERENT).unwrap();
    let out = path(folder.path(), "frames");
    let rendered =
        shadowgauge(["render", &config, "--out", &out, "--backend", "cpu", "--format", "f32", "--no-noise"]);
    assert_eq!(rendered.status.code(), Some(0), "{}", text(&rendered.stderr));
    let input = format!("{out}/frames");
    let truth = std::fs::read_to_string(format!("{out}/truth.csv")).unwrap();
    // The same edge as a file: the config's family at 1201 distances.
    let table = {
        use shadowgauge::render::esf_families::PartiallyCoherentEdge;
        let family = PartiallyCoherentEdge {
            na: 0.1,
            coherence_ratio: 0.9,
            wavelength_nm: 525.0,
            ..PartiallyCoherentEdge::default()
        };
        let spread = family.edge_spread().unwrap();
        let lines = (-600..=600).map(|k| 0.1 * f64::from(k)).map(|d| format!("{d},{}\n", spread.value(d)));
        lines.fold("d_um,intensity\n".to_owned(), |all, line| all + &line)
    };
    let file = path(folder.path(), "edge.csv");
    std::fs::write(&file, table).unwrap();
    let measured = |esf: &str| {
        let edges = path(folder.path(), "edges.csv");
        let done = shadowgauge([
            "measure",
            &input,
            "--um-per-px",
            "1.38",
            "--esf",
            esf,
            "--edges",
            &edges,
            "--json",
        ]);
        assert_eq!(done.status.code(), Some(0), "{esf}: {}", text(&done.stderr));
        departure(&std::fs::read_to_string(&edges).unwrap(), &truth)
    };
    let [gaussian, learnt, of_config, of_file] = ["gaussian", "learnt", &config, &file].map(measured);
    println!(
        "departure, width error / px: gaussian {gaussian:.4?}, learnt {learnt:.4?}, config {of_config:.4?}, file {of_file:.4?}"
    );
    for known in [of_config, of_file] {
        assert!(known.1.abs() < 0.01 && known.0 < gaussian.0, "{known:?}");
    }
    assert!(gaussian.1.abs() > 0.02, "the middle of partially coherent light stands off the edge");
    assert!((of_config.1 - of_file.1).abs() < 2e-3 && learnt.0 < gaussian.0);
    let refused = |args: &[&str], code: i32, word: &str| {
        let done = shadowgauge([&["measure", &input][..], args].concat());
        let said = text(&done.stderr);
        assert!(done.status.code() == Some(code) && said.contains(word), "{args:?}: {said}");
    };
    refused(&["--esf", "gauss"], 2, "gaussian, learnt");
    refused(&["--esf", &file], 2, "--um-per-px");
    refused(&["--esf", "/nonexistent.csv", "--um-per-px", "1"], 3, "No such file");
    let bad = path(folder.path(), "bad.csv");
    std::fs::write(&bad, "d_um,intensity\n-1,0\n1,0.5\n").unwrap();
    refused(&["--esf", &bad, "--um-per-px", "1"], 2, "8 samples");
    refused(&["--esf", "learnt", "--shape", "ring"], 2, "--shape shaft");
}

/// Two turns and a half of an oval shaft; in one frame of the second turn there is a collar of 0.07
/// mm.
#[test]
fn a_station_that_jumps_against_an_earlier_turn_is_a_gap() {
    let folder = tempfile::tempdir().unwrap();
    let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
    let mut setup = SimulatedSetup::new(&renderer, true_setup(PLAN), 0.0, 3);
    let oval = Lobe { order_upr: 2, amplitude_mm: 0.02, phase_deg: 20.0 };
    let mut table = "frame,t_ns,z_mm,angle_deg,exposure_us,bit_depth,um_per_px\n".to_owned();
    for i in 0..16 {
        let angle = 45.0 * f64::from(i);
        let grown = if i == 11 { 0.07 } else { 0.0 };
        let frame = setup.frame(&laid(5.0 + grown, angle, vec![oval])).unwrap();
        save(&frame, &folder.path().join(format!("frames/{i:06}.png")));
        table += &format!("{i:06},0,0.0,{angle},50,12,15.27\n");
    }
    std::fs::write(folder.path().join("frames.csv"), table).unwrap();
    let input = path(folder.path(), "frames");
    let measure = |more: &[&str]| {
        json(&shadowgauge([&["measure", &input, "--um-per-px", "15.27", "--json", "--turn"], more].concat()))
    };
    let all = measure(&["--station-mm", "1"]);
    let refused =
        |all: &Value, frame: usize| all["frames"][frame]["flags"]["implausible"].as_u64().unwrap_or(0);
    for frame in 0..16 {
        assert_eq!(refused(&all, frame) > 250, frame == 11, "{}", all["frames"][frame]["flags"]);
    }
    assert_eq!(all["frames"][11]["stations"][2]["flag"], "implausible");
    assert!(all["frames"][11]["mean_diameter_mm"].is_null());
    let jumps = all["turn"]["implausible"].as_array().unwrap();
    assert!(jumps.len() >= 4, "{jumps:?}");
    assert!((jumps[0]["jump_mm"].as_f64().unwrap() - 0.07).abs() < 0.003 && jumps[0]["angle_deg"] == 495.0);
    // The turn's size is that of the consistent frames; if accepted, the collar changes it.
    let gg = |all: &Value| all["turn"]["sections"][0]["gg_mm"].as_f64().unwrap();
    let believed = measure(&["--station-mm", "1", "--turn-limit-um", "200"]);
    assert_eq!(refused(&believed, 11), 0);
    println!("GG {} mm, with the collar believed {} mm", gg(&all), gg(&believed));
    assert!(gg(&believed) - gg(&all) > 0.004);
    let without = shadowgauge(["measure", &input, "--um-per-px", "15.27", "--turn-limit-um", "3"]);
    assert_eq!(without.status.code(), Some(2), "--turn-limit-um needs --turn");
}

/// A frame with 1.5 times the masters' blur: no diameter, unless requested.
#[test]
fn a_frame_out_of_focus_gives_no_diameter() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(calibrate(folder.path(), PLAN).status.code(), Some(0));
    let calibration = path(folder.path(), "calibration.json");
    let known: Value = serde_json::from_slice(&std::fs::read(&calibration).unwrap()).unwrap();
    let sigma_px = 1.5 * known["bench"]["sigma_px"].as_f64().unwrap();
    let plan = format!("{PLAN}\n[simulate.optics.esf.gaussian]\nsigma_px = {sigma_px}\n");
    let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
    let mut sharp = SimulatedSetup::new(&renderer, true_setup(PLAN), 0.0, 3);
    let mut lost = SimulatedSetup::new(&renderer, true_setup(&plan), 0.0, 3);
    save(&sharp.frame(&laid(5.0, 0.0, Vec::new())).unwrap(), &folder.path().join("part/a.png"));
    save(&lost.frame(&laid(5.0, 0.0, Vec::new())).unwrap(), &folder.path().join("part/b.png"));
    let input = path(folder.path(), "part");
    let measure = |more: &[&str]| {
        let all = ["measure", &input, "--calibration", &calibration, "--as-of", "2026-12-01", "--json"];
        shadowgauge([&all[..], more].concat())
    };
    let all = json(&measure(&[]));
    let (good, bad) = (&all["frames"][0], &all["frames"][1]);
    assert!(good["max_diameter_mm"].is_number() && good["warnings"].is_null(), "{good}");
    assert!(bad["max_diameter_mm"].is_null() && bad["mean_diameter_mm"].is_null(), "{bad}");
    assert_eq!((&bad["flags"]["blurred"], &bad["valid"]), (&Value::from(320), &Value::from(0)));
    let warning = bad["warnings"][0].as_str().unwrap();
    assert!(
        ["out of focus", "moving", "other optics", "edge model"].iter().all(|c| warning.contains(c)),
        "{warning}"
    );
    assert!(bad["max_diameter_px"].is_null() && bad["u_max_px"].is_null(), "{bad}");
    // Its edges are gaps with a reason; where no other frame remains, the command fails.
    let edges = path(folder.path(), "edges.csv");
    assert_eq!(measure(&["--edges", &edges]).status.code(), Some(0));
    let edges = std::fs::read_to_string(edges).unwrap();
    assert_eq!(edges.lines().filter(|l| l.starts_with("b,") && l.ends_with(",,,,,blurred")).count(), 320);
    let alone = path(folder.path(), "part/b.png");
    let none = shadowgauge(["measure", &alone, "--calibration", &calibration, "--as-of", "2026-12-01"]);
    assert_eq!(none.status.code(), Some(3), "{}", text(&none.stderr));
    // A diameter that was not measured is not proven good.
    assert_eq!(measure(&["--tolerance", "4.9..5.1"]).status.code(), Some(1));
    let consent = measure(&["--tolerance", "4.9..5.1", "--accept-blur"]);
    assert_eq!(consent.status.code(), Some(0), "{}", text(&consent.stderr));
    assert!(json(&consent)["frames"][1]["max_diameter_mm"].is_number());
}
