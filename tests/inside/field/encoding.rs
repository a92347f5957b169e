//! Grey values that are not proportional to the light, and files that state it.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use serde_json::Value;
use shadowgauge::frame::Encoding;
use shadowgauge::gauge::{Calibration, MasterCertificate, MasterFigure};
use tempfile::TempDir;

use super::pictures::{Picture, shaft};
use super::support::{collected, measured, shadowgauge};

/// The largest diameter, px, and its u.
fn width(document: &Value) -> (f64, f64) {
    let frame = &document["frames"][0];
    let number = |key: &str| frame[key].as_f64().unwrap_or_else(|| panic!("{key}: {frame}"));
    (number("max_diameter_px"), number("u_max_px"))
}

fn save(folder: &TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

/// The message of a refusal on stderr, in one line.
fn refusal(file: &Path, options: &[&str]) -> String {
    let mut arguments = vec!["measure".as_ref(), file.as_os_str()];
    arguments.extend(options.iter().map(std::ffi::OsStr::new));
    let output = shadowgauge(arguments);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(3), "{text}");
    assert!(output.stdout.is_empty(), "{text}");
    text.split_whitespace().filter(|w| *w != "│").collect::<Vec<_>>().join(" ")
}

fn srgb(light: f64) -> f64 {
    if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 }
}

fn bt709(light: f64) -> f64 {
    if light < 0.018 { 4.5 * light } else { 1.099 * light.powf(0.45) - 0.099 }
}

/// An ICC profile of grey whose tone curve is a power (ICC.1 10.18, parametric curve type 0).
fn profile(power: f64) -> Vec<u8> {
    let mut curve = b"para\0\0\0\0\0\0\0\0".to_vec();
    curve.extend(((power * 65_536.0) as u32).to_be_bytes());
    let mut profile = vec![0; 128];
    profile[8..12].copy_from_slice(&[4, 0x20, 0, 0]);
    profile[12..16].copy_from_slice(b"mntr");
    profile[16..20].copy_from_slice(b"GRAY");
    profile[20..24].copy_from_slice(b"XYZ ");
    profile[36..40].copy_from_slice(b"acsp");
    for (at, number) in [(68, 0xf6d6_u32), (72, 0x1_0000), (76, 0xd32d)] {
        profile[at..at + 4].copy_from_slice(&number.to_be_bytes());
    }
    profile.extend(1_u32.to_be_bytes());
    profile.extend(b"kTRC");
    profile.extend(144_u32.to_be_bytes());
    profile.extend((curve.len() as u32).to_be_bytes());
    profile.extend(curve);
    let size = (profile.len() as u32).to_be_bytes();
    profile[..4].copy_from_slice(&size);
    profile
}

/// The chunk that holds a profile: name, method, and the profile in a zlib stream of stored blocks.
fn iccp(profile: &[u8]) -> Vec<u8> {
    let mut data = b"grey\0\0\x78\x01\x01".to_vec();
    let size = profile.len() as u16;
    data.extend(size.to_le_bytes());
    data.extend((!size).to_le_bytes());
    data.extend(profile);
    let adler = profile.iter().fold((1_u32, 0_u32), |(a, b), v| {
        let a = (a + u32::from(*v)) % 65_521;
        (a, (b + a) % 65_521)
    });
    data.extend((adler.1 << 16 | adler.0).to_be_bytes());
    data
}

#[test]
fn encoded_values_measure_as_the_light_they_stand_for() {
    let folder = tempfile::tempdir().unwrap();
    let light = shaft(120, 100, 60.4, 1.3, 5);
    let linear = save(&folder, "linear.png", &Picture::of(&light, 120, 16, |l| l).png(&[]));
    let (right, u) = width(&measured(&linear, &[]));
    assert!((right - 60.4).abs() < 4.0 * u, "{right} ± {u}");
    type Encode = fn(f64) -> f64;
    let cases: [(&str, Encode, [u8; 4], Vec<u8>); 7] = [
        ("gAMA", |l| l.powf(0.45455), *b"gAMA", 45_455_u32.to_be_bytes().to_vec()),
        ("gAMA", |l| l.powf(0.6), *b"gAMA", 60_000_u32.to_be_bytes().to_vec()),
        ("sRGB", srgb, *b"sRGB", vec![0]),
        ("cICP", srgb, *b"cICP", vec![1, 13, 0, 1]),
        ("cICP", bt709, *b"cICP", vec![1, 1, 0, 1]),
        ("iCCP", |l| l.powf(1.0 / 1.8), *b"iCCP", iccp(&profile(1.8))),
        ("iCCP", |l| l.powf(1.0 / 2.2), *b"iCCP", iccp(&profile(2.2))),
    ];
    for (index, (tag, encode, chunk, data)) in cases.into_iter().enumerate() {
        for depth in [8, 16] {
            let picture = Picture::of(&light, 120, depth, encode);
            let file = save(&folder, &format!("{index}_{depth}.png"), &picture.png(&[(chunk, data.clone())]));
            let output = shadowgauge(["measure".as_ref(), file.as_os_str()]);
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(said.contains(tag) && said.contains("made linear"), "{tag}: {said}");
            let (found, u) = width(&measured(&file, &[]));
            assert!((found - 60.4).abs() < 4.0 * u && u < 0.05, "{tag}, {depth} bits: {found} ± {u}");
            // Without the tag the edges are displaced: the test can fail.
            let silent = save(&folder, "silent.png", &picture.png(&[]));
            let (raw, _) = width(&measured(&silent, &[]));
            assert!((raw - 60.4).abs() > 0.3, "{tag}: {raw}");
        }
    }
}

#[test]
fn a_word_that_linear_values_are_linear_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let picture = Picture::of(&shaft(120, 100, 60.4, 1.3, 6), 120, 8, |l| l);
    let plain = measured(&save(&folder, "a.png", &picture.png(&[])), &[]);
    for (chunk, data) in [
        (*b"gAMA", 100_000_u32.to_be_bytes().to_vec()),
        (*b"cICP", vec![1, 8, 0, 1]),
        (*b"iCCP", iccp(&profile(1.0))),
        (*b"sBIT", vec![8]),
    ] {
        let file = save(&folder, "a.png", &picture.png(&[(chunk, data)]));
        assert_eq!(measured(&file, &[]), plain, "{}", String::from_utf8_lossy(&chunk));
    }
}

#[test]
fn encodings_that_are_not_undone_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let picture = Picture::of(&shaft(120, 60, 60.4, 1.3, 7), 120, 8, |l| l.powf(0.45));
    for (chunk, data, words) in [
        (*b"cICP", vec![9, 16, 0, 1], "cICP transfer function 16: not linearised"),
        (*b"cICP", vec![1, 13, 0, 0], "narrow range"),
        (*b"gAMA", 0_u32.to_be_bytes().to_vec(), "gAMA 0: no exponent"),
        (*b"iCCP", iccp(&profile(2.2)[..100]), "iCCP: a damaged ICC profile"),
        (*b"iCCP", b"grey\0\0garbage".to_vec(), "iCCP: a profile that cannot be read"),
    ] {
        let file = save(&folder, "a.png", &picture.png(&[(chunk, data)]));
        let said = refusal(&file, &[]);
        assert!(said.contains("a.png") && said.contains(words), "{words}: {said}");
    }
}

#[test]
fn a_tiff_s_transfer_function_is_undone() {
    let folder = tempfile::tempdir().unwrap();
    let light = shaft(120, 100, 60.4, 1.3, 8);
    let picture = Picture::of(&light, 120, 8, |l| l.powf(0.5));
    let table: Vec<u16> =
        (0..256).map(|v| (65_535.0 * (f64::from(v) / 255.0).powi(2)).round() as u16).collect();
    let file = save(&folder, "a.tif", &picture.tiff().with_words(301, &table).write());
    let (found, u) = width(&measured(&file, &[]));
    assert!((found - 60.4).abs() < 4.0 * u, "{found} ± {u}");
    let short = save(&folder, "short.tif", &picture.tiff().with_words(301, &table[..100]).write());
    let said = refusal(&short, &[]);
    assert!(said.contains("tag 301: 100 values; one for each of the 256"), "{said}");
    let fallen: Vec<u16> = table.iter().rev().copied().collect();
    let falling = save(&folder, "falling.tif", &picture.tiff().with_words(301, &fallen).write());
    assert!(refusal(&falling, &[]).contains("does not grow"));
}

/// A calibration of two masters at 1 mm/px, made of frames encoded so.
fn calibration(folder: &TempDir, encoding: Option<Encoding>) -> PathBuf {
    let master = |mm: f64| MasterFigure {
        certificate: MasterCertificate { diameter_mm: mm, expanded_u_mm: 1e-3, coverage_factor: 2.0 },
        width_px: mm,
        u_width_px: 1e-3,
    };
    let fitted = Calibration::fit_figures(&[master(40.0), master(80.0)]).unwrap();
    let made = encoding.map_or(fitted.clone(), |e| fitted.with_encoding(e));
    let path = folder.path().join("calibration.json");
    let mut file = std::fs::File::create(&path).unwrap();
    write!(file, "{}", serde_json::to_string(&made).unwrap()).unwrap();
    path
}

#[test]
fn frames_encoded_otherwise_than_their_calibration_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let light = shaft(120, 60, 60.4, 1.3, 9);
    let gamma = (*b"gAMA", 45_455_u32.to_be_bytes().to_vec());
    let linear = save(&folder, "linear.png", &Picture::of(&light, 120, 8, |l| l).png(&[]));
    let encoded =
        save(&folder, "encoded.png", &Picture::of(&light, 120, 8, |l| l.powf(0.45455)).png(&[gamma]));
    let power = Encoding::of(|v| v.powf(2.2));
    for (made_of, file, words) in [
        (Some(Encoding::LINEAR), &linear, ""),
        (Some(power), &encoded, ""),
        // A file of an earlier version is valid for its own encoding, as far as that is recorded.
        (None, &linear, ""),
        (Some(Encoding::LINEAR), &encoded, "a power of 0.455 here, which there was linear"),
        (Some(Encoding::SRGB), &encoded, "a power of 0.455 here, which there was sRGB"),
        (Some(power), &linear, "linear here, which there was a power of 0.455"),
        (None, &encoded, "is not known (a calibration of an earlier version)"),
    ] {
        let path = calibration(&folder, made_of);
        let options = ["--calibration", path.to_str().unwrap(), "--json"];
        if words.is_empty() {
            let mut arguments = vec!["measure", file.to_str().unwrap()];
            arguments.extend(options);
            let output = shadowgauge(arguments);
            assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        } else {
            let said = refusal(file, &options);
            assert!(said.contains(words), "{words}: {said}");
        }
    }
}

#[test]
fn the_collected_file_measures_as_its_linear_twin() {
    let Some(folder) = collected("gamma") else { return };
    let (linear, u) = width(&measured(&folder.join("linear.png"), &[]));
    let (encoded, u_encoded) = width(&measured(&folder.join("gama_chunk.png"), &[]));
    assert!(
        (linear - 60.4).abs() < 4.0 * u && (encoded - 60.4).abs() < 4.0 * u_encoded,
        "{linear}, {encoded}"
    );
}
