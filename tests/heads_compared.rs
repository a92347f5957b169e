//! A lens is chosen: `study head` names the head with the smaller U, and rendered frames measured
//! by the program agree with it.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

#[path = "support/program.rs"]
mod program;

use std::path::{Path, PathBuf};

use program::{json, said, shadowgauge, text};

/// A head of 512 rows before a pin: `magnification` decides what a pixel is on the part.
fn head(name: &str, magnification: f64) -> String {
    format!(
        "name = \"{name}\"\n\
         [part]\nlength_mm = 2.0\nnominal_diameter_mm = [0.5]\nstation_mm = 0.2\n\
         [scan]\nfields = 1\nangles = 4\n\
         [masters]\nframes_each = 1\n\
         pins = [{{ diameter_mm = 0.45, expanded_u_mm = 0.00001 }}, {{ diameter_mm = 0.55, expanded_u_mm = 0.00001 }}]\n\
         [camera]\ncolumns = 128\nrows = 512\npixel_um = 3.45\nexposure_us = 100.0\n\
         [optics]\nmagnification = {magnification}\ndefocus_na = 0.05\ntelecentricity_mrad = 0.01\n\
         [optics.esf.gaussian]\nsigma_px = 1.2\n"
    )
}

struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    fn file(&self, name: &str, text: &str) -> PathBuf {
        let path = self.folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    /// Both heads: half the pixel on the part with the same blur in pixels, and twice of it.
    fn heads(&self) -> [PathBuf; 2] {
        [self.file("fine.toml", &head("fine", 2.0)), self.file("coarse.toml", &head("coarse", 1.0))]
    }
}

fn compared(heads: &[PathBuf], options: &[&str]) -> serde_json::Value {
    let mut arguments: Vec<&str> = vec!["study", "head", "--json", "--frames", "4"];
    arguments.extend(heads.iter().map(|p| p.to_str().unwrap()));
    arguments.extend(options);
    let output = shadowgauge(arguments);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    json(&output)
}

fn number(value: &serde_json::Value, path: &str) -> f64 {
    value.pointer(path).and_then(serde_json::Value::as_f64).unwrap_or_else(|| panic!("{path} in {value}"))
}

/// Rms of measured less true widths in frames that `render` draws and `measure` measures, µm.
fn rms_um(bench: &Bench, config: &Path, um_per_px: f64) -> f64 {
    let out = bench.folder.path().join(config.file_stem().unwrap());
    let edges = out.with_extension("csv");
    let path = |p: &Path| p.to_str().unwrap().to_owned();
    let drawn = shadowgauge([
        "render".to_owned(),
        path(config),
        "--out".to_owned(),
        path(&out),
        "--frames".to_owned(),
        "4".to_owned(),
        "--backend".to_owned(),
        "cpu".to_owned(),
    ]);
    assert_eq!(drawn.status.code(), Some(0), "{}", said(&drawn));
    let measured = shadowgauge([
        "measure".to_owned(),
        path(&out.join("frames")),
        "--um-per-px".to_owned(),
        um_per_px.to_string(),
        "--edges".to_owned(),
        path(&edges),
    ]);
    assert_eq!(measured.status.code(), Some(0), "{}", said(&measured));
    let widths = |file: &Path| -> Vec<f64> {
        let text = std::fs::read_to_string(file).unwrap();
        let width = |line: &str| {
            let cells: Vec<&str> = line.split(',').collect();
            cells[3].parse::<f64>().unwrap() - cells[2].parse::<f64>().unwrap()
        };
        text.lines().skip(1).map(width).collect()
    };
    let (found, truth) = (widths(&edges), widths(&out.join("truth.csv")));
    assert_eq!(found.len(), truth.len());
    let square: f64 = found.iter().zip(&truth).map(|(f, t)| (f - t).powi(2)).sum();
    um_per_px * (square / found.len() as f64).sqrt()
}

#[test]
fn the_better_of_two_lenses_gets_the_smaller_u() {
    let bench = Bench::new();
    let heads = bench.heads();
    let study = compared(&heads, &[]);
    assert_eq!(study["verdict"]["best"], "fine", "{}", study["verdict"]);
    let u = |k: usize| number(&study, &format!("/heads/{k}/in_use/expanded_u_um"));
    assert!(u(0) < 0.8 * u(1), "{} {}", u(0), u(1));
    // What the study predicts of a column is what its frames, and those of `render` and `measure`,
    // scatter by.
    for (k, config) in heads.iter().enumerate() {
        let at = |key: &str| number(&study, &format!("/heads/{k}/{key}"));
        let (predicted, ratio) = (at("repeatability/column_um"), at("frames/column_ratio"));
        assert!((ratio - 1.0).abs() < 0.15, "{k}: {ratio}");
        let outside = rms_um(&bench, config, at("optics/um_per_px"));
        assert!((outside / predicted - 1.0).abs() < 0.2, "{k}: {outside} {predicted}");
        assert!(at("repeatability/bound_um") <= predicted);
    }
    let measured = |k: usize| number(&study, &format!("/heads/{k}/frames/own/column_sd_um"));
    assert!(measured(0) < 0.7 * measured(1), "the better head's frames err less");
}

#[test]
fn the_better_lens_loses_where_its_edges_run_out_too_fast() {
    let bench = Bench::new();
    // A path of 5 µm at 6000 rev/min and of 33 µm at 40 000: 19 pixels of the fine head, 10 of the
    // other.
    let eccentric = ["--eccentricity-mm", "0.08", "--rpm"];
    let slow = compared(&bench.heads(), &[&eccentric[..], &["6000"]].concat());
    assert_eq!(slow["verdict"]["best"], "fine", "{}", slow["verdict"]);
    let fast = compared(&bench.heads(), &[&eccentric[..], &["40000"]].concat());
    assert_eq!(fast["verdict"]["best"], "coarse", "{}", fast["verdict"]);
    assert!(fast["heads"][0]["in_use"].is_null(), "{}", fast["heads"][0]["motion"]);
    let refused = fast["heads"][0]["motion"]["refused"].as_str().unwrap();
    assert!(refused.contains("residual"), "{refused}");
    // Moving frames of the other scatter, and depart from the truth, as predicted of smeared edges.
    let at = |path: &str| number(&fast, &format!("/heads/1/{path}"));
    assert!(at("motion/noise_factor") > 1.2);
    assert!((at("frames/column_ratio") - 1.0).abs() < 0.2, "{}", fast["heads"][1]["frames"]);
    let change = at("frames/own/mean_um") / at("motion/change_um");
    assert!((0.7..1.3).contains(&change), "{change}");
    // Without motion of the part the first has the smaller U, whatever its speed is called.
    assert!(at("at_rest/expanded_u_um") > number(&fast, "/heads/0/at_rest/expanded_u_um"));
}

/// The same lens with a tenth of the light's electrons.
#[test]
fn of_two_sensors_the_one_with_less_noise_gets_the_smaller_u() {
    let bench = Bench::new();
    let quiet = bench.file("quiet.toml", &head("quiet", 1.0));
    let noisy = head("noisy", 1.0) + "[sensor]\nelectrons_per_count = 0.26\nfull_well_e = 1050.0\n";
    let noisy = bench.file("noisy.toml", &noisy);
    let study = compared(&[noisy, quiet], &[]);
    assert_eq!(study["verdict"]["best"], "quiet", "{}", study["verdict"]);
    let sd = |k: usize| number(&study, &format!("/heads/{k}/frames/own/column_sd_um"));
    assert!(sd(1) < 0.5 * sd(0), "{} {}", sd(0), sd(1));
}

#[test]
fn files_hold_what_is_printed() {
    let bench = Bench::new();
    let heads = bench.heads();
    let [fine, coarse] = heads.each_ref().map(|p| p.to_str().unwrap());
    let out = bench.folder.path().join("out");
    let csv = bench.folder.path().join("heads.csv");
    let arguments = ["study", "head", fine, coarse, "--frames", "2", "--out", out.to_str().unwrap(), "--csv"];
    let output = shadowgauge([&arguments[..], &[csv.to_str().unwrap()]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let printed = text(&output.stdout);
    for part in ["bound, one column", "± depth / mm", "what would halve it", "fine: U = ", "times the light"]
    {
        assert!(printed.contains(part), "{part} is not in {printed}");
    }
    assert_eq!(std::fs::read(&csv).unwrap(), std::fs::read(out.join("heads.csv")).unwrap());
    let table = std::fs::read_to_string(&csv).unwrap();
    assert_eq!(table.lines().count(), 3, "{table}");
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("Heads before a part of 0.5 mm") && page.contains("<svg"), "no page");
    let document = std::fs::read_to_string(out.join("heads.json")).unwrap();
    let document: serde_json::Value = serde_json::from_str(&document).unwrap();
    assert_eq!(document["heads"].as_array().unwrap().len(), 2);
}

/// Refused with exit 2: what is wrong is named, and what would be right.
#[test]
fn heads_that_cannot_be_compared_are_refused_by_name() {
    let bench = Bench::new();
    let [fine, coarse] = bench.heads();
    let without = bench
        .file("without.toml", "name = \"x\"\n[part]\nnominal_diameter_mm = [10.0]\n[camera]\nrows = 1024\n");
    let pitch = head("pitch", 2.0).replace(
        "[optics]\n",
        "[light]\nshadow_counts = 280.0\n[sensor]\npreset = \"sony_imx900\"\n[optics]\n",
    );
    let pitch = bench.file("pitch.toml", &pitch);
    let other = bench.file("other.toml", &head("other", 2.0).replace("[0.5]", "[0.4]"));
    let plan = bench.file("plan.toml", "optics_id = \"x\"\n");
    let cases: [(Vec<&Path>, &[&str], &str); 7] = [
        (vec![&without], &[], "has no [optics]"),
        (vec![&plan], &[], "is a calibration's file"),
        (vec![&fine, &fine], &[], "name each head once"),
        (vec![&fine, &other], &[], "states the one to compare the heads at"),
        (vec![&pitch], &[], "write pixel_um = 2.25"),
        (vec![&fine, &coarse], &["--diameter-mm", "1.2"], "is larger than this head can have in its field"),
        (vec![&fine], &["--diameter-mm", "0.001"], "is smaller than this head can measure"),
    ];
    for (configs, options, wanted) in cases {
        let mut arguments: Vec<&str> = vec!["study", "head"];
        arguments.extend(configs.iter().map(|p| p.to_str().unwrap()));
        arguments.extend(options);
        let output = shadowgauge(arguments);
        let said = said(&output);
        assert_eq!(output.status.code(), Some(2), "{wanted}: {said}");
        assert!(said.contains(wanted), "{wanted} is not in {said}");
        assert!(output.stdout.is_empty(), "{wanted}");
    }
}
