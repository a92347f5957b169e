//! Sizes: the largest diameter over stretches, crests opposite roots, several shadows in one field.

use std::path::PathBuf;

use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use serde_json::Value;
use statrs::function::erf::erf;

use crate::inside::field::support::{collected, measured, shadowgauge};

const NOISE_COUNTS: f64 = 1.5;

/// A backlit frame of 8 bit: shadows between (upper, lower) edges of a column, blurred by 0.8 px.
fn frame(
    name: &str,
    size: (u32, u32),
    seed: u64,
    shadows: impl Fn(f64) -> Vec<(f64, f64)>,
) -> (tempfile::TempDir, PathBuf) {
    let normal = Normal::new(0.0, NOISE_COUNTS).unwrap();
    let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
    let light = |distance: f64| 0.5 * (1.0 + erf(distance / (0.8 * std::f64::consts::SQRT_2)));
    let mut image = image::GrayImage::new(size.1, size.0);
    for column in 0..size.1 {
        let edges = shadows(f64::from(column));
        for row in 0..size.0 {
            // Three points across a pixel: Simpson's rule over its area.
            let at =
                |row: f64| edges.iter().map(|(t, b)| 1.0 - light(row - t) * light(b - row)).product::<f64>();
            let row_px = f64::from(row);
            let share = (at(row_px - 0.5) + 4.0 * at(row_px) + at(row_px + 0.5)) / 6.0;
            let grey = 20.0 + 180.0 * share + normal.sample(&mut rng);
            image.put_pixel(column, row, image::Luma([grey.round().clamp(0.0, 255.0) as u8]));
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("{name}.png"));
    image.save(&path).unwrap();
    (folder, path)
}

fn first(document: &Value) -> &Value {
    &document["frames"][0]
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("no {key} in {value}"))
}

fn warnings(frame: &Value) -> String {
    frame["warnings"].as_array().map_or_else(String::new, |w| format!("{w:?}"))
}

/// Error of the largest diameter over its u, and u.
fn over_u(document: &Value, right_px: f64) -> (f64, f64) {
    let frame = first(document);
    let u = number(frame, "u_max_px");
    ((number(frame, "max_diameter_px") - right_px) / u, u)
}

type Form = fn(f64) -> f64;

/// Tapers, bumps, collars and waves through pixels: the largest diameter within 3 u each, at its
/// true place.
#[test]
fn the_largest_diameter_of_tapers_bumps_collars_and_waves_is_reached() {
    let forms: [(&str, Form, f64, Option<f64>); 6] = [
        ("cylinder", |_| 0.0, 0.0, None),
        ("taper", |c| 0.02 * c, 0.02 * 399.0, Some(399.0)),
        ("bump", |c| (-0.5 * ((c - 170.0) / 14.0).powi(2)).exp(), 1.0, Some(170.0)),
        ("collar", |c| if (200.0..230.0).contains(&c) { 0.8 } else { 0.0 }, 0.8, Some(215.0)),
        ("waves", |c| 0.5 * (c / 9.5).sin(), 0.5, None),
        ("long waves", |c| 2.0 * (c / 40.0).sin(), 2.0, None),
    ];
    let (mut square, mut n) = (0.0, 0.0);
    for (k, (name, form, right, place)) in forms.into_iter().enumerate() {
        for seed in 0..2 {
            let (_kept, path) = frame(name, (160, 400), 10 * k as u64 + seed, |c| {
                vec![(45.3 - 0.5 * form(c), 105.8 + 0.5 * form(c))]
            });
            let document = measured(&path, &[]);
            let (error, u) = over_u(&document, 60.5 + right);
            println!("{name}: {error:.2} u, u {u:.4} px, {}", first(&document)["max_stretch_px"]);
            assert!(error.abs() < 3.0 && u < 0.03, "{name}: {error} u, u {u}");
            if let Some(place) = place {
                let off = (number(first(&document), "max_column_px") - place).abs();
                assert!(off < 16.0, "{name}: {off} columns off");
            }
            (square, n) = (square + error * error, n + 1.0);
        }
    }
    let rms = (square / n).sqrt();
    assert!((0.4..1.5).contains(&rms), "{rms}");
}

/// A bump above the limit that a mean over 65 columns hides is not GO; its place and its stretch
/// are reported with the judgement.
#[test]
fn a_bump_narrower_than_a_local_size_is_not_good() {
    let (_kept, path) = frame("bump", (160, 400), 5, |c| {
        let bump = if (90.0..104.0).contains(&c) { 0.2 } else { 0.0 };
        vec![(45.3 - bump, 105.3 + bump)]
    });
    let good = measured(&path, &["--tolerance", "59.8..60.5"]);
    let narrow = measured(&path, &["--tolerance", "59.8..60.25"]);
    assert_eq!(first(&good)["judgement"], "GO", "{good}");
    assert_ne!(first(&narrow)["judgement"], "GO", "{narrow}");
    let stretch = number(first(&narrow), "max_stretch_columns");
    assert!(stretch <= 14.0 && (number(first(&narrow), "max_z_mm") + 102.5).abs() < 6.0, "{narrow}");
    // Over stretches of 120 columns and more the bump is an eighth of them.
    let wide = measured(&path, &["--stretch-columns", "120"]);
    assert!(number(first(&wide), "max_stretch_columns") >= 120.0, "{wide}");
    assert!((number(first(&wide), "max_diameter_px") - 60.05).abs() < 0.02, "{wide}");
}

/// Crests opposite roots: the distance of the tangents, not the largest width of a column.
#[test]
fn a_knurls_caliper_touches_its_crests() {
    let wave = |c: f64| 1.5 * (std::f64::consts::TAU * c / 24.0).cos();
    let (_kept, path) = frame("knurl", (200, 400), 3, |c| vec![(60.2 + wave(c), 140.6 + wave(c))]);
    let document = measured(&path, &[]);
    let (error, u) = over_u(&document, 83.4);
    assert!(error.abs() < 3.0 && u < 0.06, "{error} u, u {u}");
    assert_eq!(first(&document)["max_of"], "tangents");
}

/// Height of an ISO 68-1 thread of pitch `p` under its crest: flats of p/8 and p/4, flanks of 60°.
fn under_crest(along: f64, p: f64) -> f64 {
    let from_crest = ((along / p).rem_euclid(1.0) - 0.5).abs();
    3.0_f64.sqrt() * p * (from_crest.clamp(1.0 / 16.0, 0.375) - 1.0 / 16.0)
}

#[test]
fn a_threads_crest_diameter_is_measured_and_named() {
    for pitch in [40.0, 64.0] {
        let (_kept, path) = frame("thread", (300, 400), 4, |c| {
            vec![(60.2 + under_crest(c, pitch), 220.6 - under_crest(c + 0.5 * pitch, pitch))]
        });
        let document = measured(&path, &[]);
        let (error, u) = over_u(&document, 160.4);
        assert!(error.abs() * u < 0.1 && u < 0.7, "pitch {pitch}: {error} u, u {u}");
        assert!((number(first(&document), "crest_pitch_px") / pitch - 1.0).abs() < 0.1);
        assert!(warnings(first(&document)).contains("thread"), "{document}");
    }
}

/// A pin with a bright line inside is one part; the walls of a tube are refused unless stated.
#[test]
fn one_wall_is_not_the_part() {
    let pin = |gap: f64, at: f64| {
        frame("pin", (260, 300), 6, move |_| vec![(40.2, at - 0.5 * gap), (at + 0.5 * gap, 200.6)])
    };
    for (gap, at) in [(5.0, 120.0), (8.0, 90.0), (12.0, 130.0)] {
        let (_kept, path) = pin(gap, at);
        let document = measured(&path, &[]);
        let (error, u) = over_u(&document, 160.4);
        assert!(error.abs() < 4.0 && u < 0.03, "line of {gap} px: {error} u, u {u}");
        assert!(warnings(first(&document)).contains("one part"), "{document}");
    }
    let (_kept, tube) = pin(30.2, 120.4);
    let output = shadowgauge(["measure", tube.to_str().unwrap(), "--um-per-px", "1000"]);
    let words = String::from_utf8_lossy(&output.stderr).replace("\n  │ ", " ");
    assert_eq!(output.status.code(), Some(3), "{words}");
    assert!(words.contains("several_shadows") && words.contains("--which outermost"), "{words}");
    for (which, right) in [("outermost", 160.4), ("1", 65.1), ("2", 65.1)] {
        let (error, _) = over_u(&measured(&tube, &["--which", which]), right);
        assert!(error.abs() < 4.0, "--which {which}: {error} u");
    }
}

#[test]
fn a_capillary_is_measured_from_its_outermost_edges() {
    let (_kept, path) =
        frame("capillary", (200, 300), 7, |_| vec![(30.3, 70.2), (74.2, 114.1), (118.3, 158.2)]);
    let (error, _) = over_u(&measured(&path, &[]), 127.9);
    assert!(error.abs() < 4.0, "{error} u");
}

/// A second shadow of the same size is named, and no frame is judged good until the shadow is
/// chosen.
#[test]
fn a_second_part_is_named() {
    let (_kept, path) = frame("wires", (300, 300), 8, |_| vec![(40.3, 80.6), (130.2, 170.7)]);
    let document = measured(&path, &["--tolerance", "40..41"]);
    let frame = first(&document);
    assert!(warnings(frame).contains("was left out") && frame["judgement"].is_null(), "{frame}");
    assert_eq!((frame["shadows"]["seen"].as_u64(), frame["shadows"]["joined"].as_u64()), (Some(2), Some(1)));
    for (which, right) in [("1", 40.3), ("2", 40.5), ("nearest-centre", 40.5)] {
        let document = measured(&path, &["--which", which, "--tolerance", "40..41"]);
        let (error, _) = over_u(&document, right);
        assert!(error.abs() < 4.0 && first(&document)["judgement"] == "GO", "--which {which}: {error} u");
    }
    let none = shadowgauge(["measure", path.to_str().unwrap(), "--which", "3"]);
    assert_eq!(none.status.code(), Some(3), "{}", String::from_utf8_lossy(&none.stderr));
    let wrong = shadowgauge(["measure", path.to_str().unwrap(), "--which", "left"]);
    assert_eq!(wrong.status.code(), Some(2));
}

#[test]
fn rejection_is_stated_on_the_command_line() {
    // A tooth on one side: refused as contamination of the part, unless each edge is measured by
    // itself.
    let (_kept, path) = frame("tooth", (160, 400), 9, |c| {
        let tooth = if (150.0..220.0).contains(&c) { 0.9 } else { 0.0 };
        vec![(45.3 - tooth, 105.8)]
    });
    let measured = |how: &str| measured(&path, &["--rejection", how]);
    for (how, right_px, least, most) in
        [("full", 60.5, 250.0, 335.0), ("by_edge", 61.4, 390.0, 400.0), ("off", 61.4, 400.0, 400.0)]
    {
        let document = measured(how);
        let (valid, (error, _)) = (number(first(&document), "valid"), over_u(&document, right_px));
        assert!((least..=most).contains(&valid) && error.abs() < 4.0, "{how}: {valid} columns, {error} u");
    }
    let wrong = shadowgauge(["measure", path.to_str().unwrap(), "--rejection", "some"]);
    assert_eq!(wrong.status.code(), Some(2));
}

#[test]
fn the_collections_taper_and_wires() {
    if let Some(path) = collected("taper/one_to_fifty.png") {
        let (error, u) = over_u(&measured(&path, &[]), 104.39);
        assert!(error.abs() < 3.0 && u < 0.03, "{error} u, u {u}");
    }
    if let Some(path) = collected("several/two_wires.png") {
        let document = measured(&path, &[]);
        assert!(warnings(first(&document)).contains("was left out"), "{document}");
        let (error, _) = over_u(&measured(&path, &["--which", "1"]), 40.3);
        assert!(error.abs() < 4.0, "{error} u");
    }
}
