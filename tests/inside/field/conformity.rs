//! Tolerances as on drawings, the sizes that they apply to, and the decision rule.

use std::path::{Path, PathBuf};
use std::process::Output;

use rand::SeedableRng as _;
use rand_distr::Distribution as _;
use serde_json::Value;

use super::support::{json, said, shadowgauge, text};

pub(super) const COLUMNS: u32 = 192;

/// A shaft of a diameter (px) with the height of its axis by column (px above the middle of the
/// frame), blurred by 1 px, noise 1 count.
pub(super) fn draw(path: &Path, diameter: f64, seed: u64, height: impl Fn(f64) -> f64) {
    let mut random = rand_pcg::Pcg64::seed_from_u64(seed);
    let noise = rand_distr::Normal::new(0.0, 1.0).unwrap();
    let (columns, rows) = (COLUMNS, 160);
    let step = |x: f64| 0.5 * (1.0 + libm::erf(x / 2.0_f64.sqrt()));
    let mut image = image::GrayImage::new(columns, rows);
    for (column, row, pixel) in image.enumerate_pixels_mut() {
        let away = f64::from(row) - (79.7 - height(f64::from(column)));
        let light = 1.0 - step(away + 0.5 * diameter) + step(away - 0.5 * diameter);
        let grey = 20.0 + 180.0 * light + noise.sample(&mut random);
        *pixel = image::Luma([grey.round().clamp(0.0, 255.0) as u8]);
    }
    image.save(path).unwrap();
}

/// `measure` at 1 mm per pixel.
fn measure(inputs: &[PathBuf], more: &[&str]) -> Output {
    let inputs = inputs.iter().map(|p| p.as_os_str());
    let more = ["--um-per-px", "1000", "--json"].iter().chain(more).map(std::ffi::OsStr::new);
    shadowgauge(std::iter::once("measure".as_ref()).chain(inputs).chain(more))
}

#[test]
fn the_command_line_reads_drawings_and_names_what_it_cannot_judge() {
    let folder = tempfile::tempdir().unwrap();
    let part = folder.path().join("part.png");
    draw(&part, 60.0, 1, |_| 0.0);
    let part = [part];
    // 60 js15 is 59.4 to 60.6, 60 e12 is 59.64 to 59.94.
    for (tolerance, judgement) in [
        ("60 ±0.5", "GO"),
        ("Ø60±0,5", "GO"),
        ("⌀60js15", "GO"),
        ("60 (+0.5/−0.5) Ⓛⓟ", "GO"),
        ("59,5 … 60,5", "GO"),
        ("60 +1.0/+0.5", "LL"),
        ("60 e12", "HH"),
    ] {
        let output = measure(&part, &["--tolerance", tolerance]);
        let document = json(&output);
        assert_eq!(document["frames"][0]["judgement"], judgement, "{tolerance}: {document}");
        assert_eq!(output.status.code(), Some(i32::from(judgement != "GO")), "{tolerance}");
    }
    for (tolerance, reason) in [
        ("60", "bare size"),
        ("60 H7", "class of a hole"),
        ("60 H7/h6", "fit"),
        ("60 h6 (GG)", "hollows"),
        ("60 j9", "grades 5 to 8"),
        ("60 0/-13", "micrometres"),
        ("60 ±0.5 Ⓔ", "--turn"),
        ("60 ±0.5 (GN)", "--turn"),
    ] {
        let output = measure(&part, &["--tolerance", tolerance]);
        let said = said(&output);
        assert_eq!(output.status.code(), Some(2), "{tolerance}: {said}");
        assert!(said.contains(reason) && output.stdout.is_empty(), "{tolerance}: {said}");
    }
}

#[test]
fn configs_read_the_same_texts() {
    let folder = tempfile::tempdir().unwrap();
    let job = folder.path().join("job.toml");
    let small = include_str!("../../support/small_render_job.toml");
    let render = |tolerance: &str| {
        let line = format!("station_mm = 0.5\ntolerance = {tolerance}\n");
        std::fs::write(&job, small.replace("station_mm = 0.5\n", &line)).unwrap();
        let words = ["render".as_ref(), job.as_os_str(), "--bench".as_ref(), "1".as_ref()];
        shadowgauge(words.into_iter().chain(["--backend", "cpu"].map(std::ffi::OsStr::new)))
    };
    for tolerance in ["\"1 js9\"", "\"Ø1 ±0,01\"", "{ nominal_mm = 1.0, upper_mm = 0.01, lower_mm = -0.01 }"]
    {
        let output = render(tolerance);
        assert_eq!(output.status.code(), Some(0), "{tolerance}: {}", text(&output.stderr));
    }
    for (tolerance, words) in [
        ("\"1\"", ["bare size", "job.toml"]),
        ("1.0", ["bare size", "job.toml"]),
        ("\"1 H7\"", ["class of a hole", "job.toml"]),
        ("\"1 h14\"", ["up to 1 mm", "job.toml"]),
        ("\"1 js9 (E)\"", ["measure --turn", "part.tolerance"]),
        ("{ nominal_mm = 1.0, upper_um = 10.0, lower_mm = -0.01 }", ["upper_mm", "unknown field"]),
    ] {
        let output = render(tolerance);
        let said = said(&output);
        assert_eq!(output.status.code(), Some(2), "{tolerance}: {said}");
        assert!(words.iter().all(|word| said.contains(word)), "{tolerance}: {said}");
    }
    let schema = text(&shadowgauge(["schema"]).stdout);
    assert!(schema.contains("As on drawings") && schema.contains("conformance_probability"));
}

/// Frames of a turn of a shaft of 60 px with a sagitta between its ends.
fn turn(folder: &Path, sagitta: f64) -> Vec<PathBuf> {
    (0..24_u32)
        .map(|k| {
            let path = folder.join(format!("{k:02}.png"));
            let phi = (15.0 * f64::from(k)).to_radians();
            let middle = 0.5 * f64::from(COLUMNS - 1);
            let bow = |column: f64| sagitta * (1.0 - (column / middle - 1.0).powi(2));
            draw(&path, 60.0, u64::from(k), |column| bow(column) * phi.cos());
            path
        })
        .collect()
}

/// A bent shaft has good two-point sizes and does not pass through the ring that its envelope must:
/// D + sagitta.
#[test]
fn the_envelope_is_judged_over_the_length() {
    let folder = tempfile::tempdir().unwrap();
    let of = |frames: &[PathBuf], tolerance: &str| {
        let output = measure(frames, &["--turn", "--angle-step", "15", "--tolerance", tolerance]);
        (output.status.code(), json(&output))
    };
    let bent = turn(folder.path(), 1.0);
    let (code, document) = of(&bent, "60 ±0.5");
    assert_eq!(code, Some(0), "{document}");
    assert!(document["turn"]["judged"].is_null());
    for tolerance in ["60 ±0.5 Ⓔ", "60 ±0.5 (GN)"] {
        let (code, document) = of(&bent, tolerance);
        let judged = &document["turn"]["judged"];
        let (d_mm, u_mm) = (judged["d_mm"].as_f64().unwrap(), judged["u_mm"].as_f64().unwrap());
        // The outer sections of 8 columns have their middles half their length inside the frame;
        // noise increases the envelope.
        let expected = 60.0 + (f64::from(COLUMNS - 8) / f64::from(COLUMNS - 1)).powi(2);
        assert!((-0.02..0.08).contains(&(d_mm - expected)) && u_mm < 0.05, "{judged} {expected}");
        assert_eq!((code, &judged["judgement"]), (Some(1), &"HH".into()), "{tolerance}: {judged}");
    }
    // The envelope may exceed a lower limit that a two-point size violates, but not the converse.
    let (code, document) = of(&bent, "61.5 ±1.0 (E)");
    assert_eq!((code, &document["turn"]["judged"]["judgement"]), (Some(1), &"GO".into()), "{document}");
    let (code, document) = of(&bent, "61.5 ±1.0 (GN)");
    assert_eq!((code, &document["turn"]["judged"]["judgement"]), (Some(0), &"GO".into()), "{document}");
    assert!(document["frames"][0]["judgement"].is_null());
    let straight = turn(folder.path(), 0.0);
    for tolerance in ["60 ±0.5 Ⓔ", "60 ±0.5 (GN)", "60 ±0.5 (GN) ACS"] {
        let (code, document) = of(&straight, tolerance);
        let judged = &document["turn"]["judged"];
        assert_eq!((code, &judged["judgement"]), (Some(0), &"GO".into()), "{tolerance}: {judged}");
    }
}

/// Cp belongs to a process: there is none for one part, and none for scatter of the gauge alone.
#[test]
fn capability_needs_parts_that_differ() {
    let folder = tempfile::tempdir().unwrap();
    let parts = |name: &str, spread: f64| -> Vec<PathBuf> {
        (0..6_u32)
            .map(|k| {
                let path = folder.path().join(format!("{name}{k}.png"));
                draw(&path, 60.0 + spread * (f64::from(k) - 2.5), 50 + u64::from(k), |_| 0.0);
                path
            })
            .collect()
    };
    let (alike, differing) = (parts("alike", 0.0), parts("differing", 0.1));
    let statistics = |frames: &[PathBuf], more: &[&str]| {
        let output = measure(frames, &[&["--tolerance", "60 ±1.0"], more].concat());
        json(&output)["statistics"].clone()
    };
    for (frames, more, reason) in [
        (&differing[..], &[][..], "--parts"),
        (&differing[..1], &["--parts"][..], "at least 2"),
        (&alike[..], &["--parts"][..], "random uncertainty"),
    ] {
        let s = statistics(frames, more);
        assert!(s["cp"].is_null() && s["cpk"].is_null(), "{s}");
        assert!(s["capability_none"].as_str().unwrap().contains(reason), "{s}");
    }
    // s of 0.1·(−2.5 … 2.5) is 0.187 mm: Cp = 2/(6·0.187) = 1.78.
    let s = statistics(&differing, &["--parts"]);
    assert!((s["cp"]["index"].as_f64().unwrap() - 1.782).abs() < 0.05, "{s}");
    assert!(s["capability_none"].is_null());
    let contrary = measure(&differing, &["--parts", "--turn", "--angle-step", "60"]);
    assert_eq!(contrary.status.code(), Some(2));
}

/// The rule at the narrowest zone, from outside: a zone of 2 U accepts a reading in its middle, a
/// narrower one none at all.
#[test]
fn zones_down_to_two_expanded_uncertainties_accept() {
    let folder = tempfile::tempdir().unwrap();
    let part = folder.path().join("part.png");
    draw(&part, 60.0, 9, |_| 0.0);
    let part = [part];
    let judged = |lower: f64, upper: f64| {
        let document = json(&measure(&part, &["--tolerance", &format!("{lower:.6}..{upper:.6}")]));
        document["frames"][0].clone()
    };
    let wide = judged(59.0, 61.0);
    let number = |frame: &Value, key: &str| frame["judged"][key].as_f64().unwrap();
    // The u that counts is that of the decisive value, which is the largest one.
    let (d, u) = (number(&wide, "d_mm"), number(&wide, "u_mm"));
    let narrow = judged(d - 0.3 * u, d + 0.3 * u);
    assert_ne!(narrow["judgement"], "GO", "{narrow}");
    assert!(narrow["acceptance_zone"].as_str().unwrap().contains("leaves no acceptance zone"), "{narrow}");
    assert!(narrow["judged"]["guard_mm"].is_null());
}
