//! The order of frames, and their metadata: tables, orientation, scale.

use std::path::{Path, PathBuf};
use std::process::Output;

use serde_json::Value;
use shadowgauge::gauge::{Calibration, MasterCertificate, MasterFigure};
use tempfile::TempDir;

use super::pictures::{Picture, shaft};
use super::support::{collected, json, measured, said, shadowgauge};

fn save(folder: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.join(name);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(&path, bytes).unwrap();
    path
}

fn run(inputs: &[&Path], options: &[&str]) -> Output {
    let inputs = inputs.iter().map(|p| p.as_os_str());
    shadowgauge(
        std::iter::once("measure".as_ref()).chain(inputs).chain(options.iter().map(std::ffi::OsStr::new)),
    )
}

fn names(document: &Value) -> Vec<&str> {
    document["frames"].as_array().unwrap().iter().filter_map(|f| f["frame"].as_str()).collect()
}

/// A frame of a shaft of `width` px.
fn frame(width: f64, seed: u64) -> Picture {
    Picture::of(&shaft(100, 24, width, 1.2, seed), 100, 8, |l| l)
}

#[test]
fn a_folder_is_read_in_the_order_of_its_numbers_which_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let names_of = |n: usize| format!("img{n}.png");
    for n in [0, 1, 2, 9, 10, 11, 100] {
        save(folder.path(), &names_of(n), &frame(40.0 + 0.1 * n as f64, n as u64).png(&[]));
    }
    // A file of a foreign system beside the frames is not a frame.
    save(folder.path(), "._img0.png", b"\0\x05\x16\x07");
    let output = run(&[folder.path()], &["--json"]);
    assert_eq!(names(&json(&output)), ["img0", "img1", "img2", "img9", "img10", "img11", "img100"]);
    assert!(said(&output).contains("order of their numbers"), "{}", said(&output));
    assert_eq!(said(&output).matches("order of their numbers").count(), 1);
    // Padded names are in that order anyway, and there is no notice.
    let padded = tempfile::tempdir().unwrap();
    for n in [0, 9, 10] {
        save(padded.path(), &format!("{n:06}.png"), &frame(40.0, n).png(&[]));
    }
    let output = run(&[padded.path()], &["--json"]);
    assert_eq!((names(&json(&output)), said(&output)), (vec!["000000", "000009", "000010"], String::new()));
    // Files that a shell has sorted alphabetically keep that order, with a notice.
    let files: Vec<PathBuf> = [0, 1, 10, 2].map(|n| folder.path().join(names_of(n.min(100)))).to_vec();
    let output = run(&files.iter().map(PathBuf::as_path).collect::<Vec<_>>(), &["--json"]);
    assert_eq!(names(&json(&output)), ["img0", "img1", "img10", "img2"]);
    assert!(said(&output).contains("in the order given, img10.png before img2.png"), "{}", said(&output));
}

#[test]
fn the_collected_turn_is_read_in_order() {
    let Some(folder) = collected("order") else { return };
    let output = run(&[&folder], &["--um-per-px", "1", "--turn", "--angle-step", "30", "--json"]);
    let document = json(&output);
    assert_eq!(names(&document)[..3], ["img0", "img1", "img2"]);
    // GN - GX is 2.10 µm; in alphabetical order 1.50 µm.
    let section = &document["turn"]["sections"][0];
    let um = |key: &str| 1e3 * section[key].as_f64().unwrap_or_else(|| panic!("{key}: {section}"));
    assert!((um("gn_mm") - um("gx_mm") - 2.1).abs() < 0.03, "{section}");
}

#[test]
fn a_table_of_a_spreadsheet_gives_depth_and_angles() {
    let light: Vec<f64> = shaft(100, 24, 40.4, 1.2, 3).iter().map(|l| 1.6 * l).collect();
    // Ten bits in sixteen, clipped at 1023: without its depth nothing is clipped.
    let clipped = Picture::of(&light, 100, 16, |l| (l.min(1.0) * 1023.0) / 65_535.0);
    for table in [
        "frame,angle_deg,bit_depth\n000000,0,10\n000001,90.5,10\n",
        "frame;angle_deg;bit_depth\r\n0;0,0;10\r\n1;90,5;10\r\n",
        "\u{feff}\"frame\"\t\"angle_deg\"\t\"bit_depth\"\r000000\t0\t10\r000001\t90,5\t10",
        "sep=;\nframe;angle_deg;bit_depth;;\n000000.tif;0;10;;\n000001.tif;90,5;10;;\n;;;;\n",
    ] {
        let folder = tempfile::tempdir().unwrap();
        save(folder.path(), "frames.csv", table.as_bytes());
        for n in 0..2 {
            save(folder.path(), &format!("frames/00000{n}.tif"), &clipped.tiff().write());
        }
        let document = measured(folder.path(), &[]);
        let flags = document["frames"][1]["flags"].as_object().unwrap();
        assert!(flags.keys().any(|k| k == "clipped" || k == "saturated"), "{table:?}: {document}");
    }
    let Some(folder) = collected("frames_csv") else { return };
    let document = shadowgauge(["measure".as_ref(), folder.as_os_str(), "--json".as_ref()]);
    let text = String::from_utf8_lossy(&document.stdout).into_owned() + &said(&document);
    assert!(text.contains("clipped") || text.contains("saturated"), "{text}");
}

#[test]
fn rows_and_images_without_a_partner_are_named() {
    let folder = tempfile::tempdir().unwrap();
    for n in 0..3 {
        save(folder.path(), &format!("{n}.png"), &frame(40.0, n).png(&[]));
    }
    let table = |text: &str| save(folder.path(), "frames.csv", text.as_bytes());
    table("frame,angle_deg\n0,0\n1,120\n2,240\n7,300\n");
    let output = run(&[folder.path()], &["--json"]);
    assert_eq!(output.status.code(), Some(0));
    assert!(said(&output).contains("frames.csv, row 5: no image of frame 7"), "{}", said(&output));
    // An image without a row would be at 0 degrees and 0 mm: refused.
    table("frame,angle_deg\n0,0\n1,120\n");
    let output = run(&[folder.path()], &["--json"]);
    let document = json(&output);
    assert!(
        document["frames"][2]["max_diameter_px"].is_null()
            && !document["frames"][1]["max_diameter_px"].is_null()
    );
    assert!(said(&output).contains("has no row for frame 2"), "{}", said(&output));
    for (text, words) in [
        ("frame,angle_deg\n0,0\n1,120\n1,240\n", "row 4: frame 1 stands in row 3, too"),
        ("image,angle_deg\n0,0\n", "row 1: no column `frame`"),
        ("frame,angle_deg\n0,0\n1,hundred\n2,3\n", "row 3: angle_deg \"hundred\"; a number"),
        ("frame,angle_deg\n0,0,5\n", "row 2: 3 fields under 2 names (a decimal comma"),
    ] {
        table(text);
        let output = run(&[folder.path()], &["--json"]);
        assert_eq!(output.status.code(), Some(3), "{text:?}");
        assert!(said(&output).contains(words), "{text:?}: {}", said(&output));
    }
}

/// An EXIF block of one orientation.
fn exif(orientation: u16) -> Vec<u8> {
    let mut block = b"MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01".to_vec();
    block.extend(orientation.to_be_bytes());
    block.extend([0; 6]);
    block
}

#[test]
fn orientation_tags_set_pictures_upright() {
    let folder = tempfile::tempdir().unwrap();
    let level = frame(40.4, 4);
    // The level shaft as a camera on its side stores it.
    let turned = Picture {
        rows: level.columns,
        columns: level.rows,
        values: (0..level.columns)
            .flat_map(|c| (0..level.rows).map(move |r| (r, c)))
            .map(|(r, c)| level.values[r * level.columns + c])
            .collect(),
        bits: 8,
    };
    let right = measured(&save(folder.path(), "level.png", &level.png(&[])), &[]);
    let right = right["frames"][0]["max_diameter_px"].as_f64().unwrap();
    for orientation in 1..=8 {
        let picture = if orientation > 4 { &turned } else { &level };
        let tagged = [
            save(folder.path(), "a.png", &picture.png(&[(*b"eXIf", exif(orientation))])),
            save(folder.path(), "a.tif", &picture.tiff().with_word(274, orientation).write()),
        ];
        for file in tagged {
            let document = measured(&file, &[]);
            assert_eq!(document["frames"][0]["columns"], 24, "{orientation}: {}", file.display());
            let found = document["frames"][0]["max_diameter_px"].as_f64().unwrap();
            // The largest of a mirrored row is taken over other windows.
            assert!((found - right).abs() < 0.03, "{orientation}: {found}, {right}");
        }
    }
}

/// A calibration of masters at 1 mm/px with files that state 1.005 and 1.02.
#[test]
fn a_calibrated_scale_goes_before_a_nominal_one_that_is_near() {
    let folder = tempfile::tempdir().unwrap();
    let master = |mm: f64| MasterFigure {
        certificate: MasterCertificate { diameter_mm: mm, expanded_u_mm: 1e-3, coverage_factor: 2.0 },
        width_px: mm,
        u_width_px: 1e-3,
    };
    let made =
        serde_json::to_string(&Calibration::fit_figures(&[master(30.0), master(60.0)]).unwrap()).unwrap();
    let calibration = save(folder.path(), "calibration.json", made.as_bytes());
    let image = save(folder.path(), "a.png", &frame(40.4, 5).png(&[]));
    let options = ["--calibration", calibration.to_str().unwrap(), "--json"];
    for (um_per_px, code, words) in [
        (1000.5, 0, ""),
        (1005.0, 0, "a scale of 1005.000000 µm/px, but the calibration is 1000.000000 µm/px"),
        (1020.0, 3, "they differ by more than .1 %: give the right one"),
    ] {
        save(folder.path(), "frames.csv", format!("frame,um_per_px\na,{um_per_px}\n").as_bytes());
        let output = run(&[&image], &options);
        let told = said(&output);
        assert_eq!(output.status.code(), Some(code), "{um_per_px}: {told}");
        assert!(told.contains(words) && told.is_empty() == words.is_empty(), "{um_per_px}: {told}");
    }
}

/// `pHYs` of a scale.
fn phys(um_per_px: f64) -> ([u8; 4], Vec<u8>) {
    let metre = ((1e6 / um_per_px).round() as u32).to_be_bytes();
    (*b"pHYs", [metre.as_slice(), &metre, &[1]].concat())
}

#[test]
fn the_scale_of_the_file_is_taken_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let picture = frame(40.4, 5);
    let centimetre = picture
        .tiff()
        .with_ratio(282, 5_747_126, 10_000)
        .with_ratio(283, 5_747_126, 10_000)
        .with_word(296, 3);
    for (name, bytes) in [
        ("a.png", picture.png(&[phys(17.4)])),
        ("a.tif", centimetre.write()),
        ("table/a.png", picture.png(&[])),
    ] {
        let file = save(folder.path(), name, &bytes);
        save(folder.path(), "table/frames.csv", b"frame,um_per_px\na,17.4\n");
        let output = run(&[&file], &["--um-per-px", "file", "--json"]);
        let document = json(&output);
        let mm =
            document["frames"][0]["max_diameter_mm"].as_f64().unwrap_or_else(|| panic!("{name}: {document}"));
        let px = document["frames"][0]["max_diameter_px"].as_f64().unwrap();
        assert!((1e3 * mm / px / 17.4 - 1.0).abs() < 1e-5, "{name}: {mm} mm, {px} px");
    }
}

#[test]
fn scales_that_differ_are_refused() {
    let folder = TempDir::new().unwrap();
    let a = save(folder.path(), "a.png", &frame(40.4, 6).png(&[phys(17.4)]));
    let b = save(folder.path(), "b.png", &frame(40.4, 7).png(&[phys(17.4 * 1.002)]));
    let screen = save(folder.path(), "screen.png", &frame(40.4, 8).png(&[phys(25_400.0 / 72.0)]));
    let bare = save(folder.path(), "bare.png", &frame(40.4, 9).png(&[]));
    let tabled = save(folder.path(), "t/a.png", &frame(40.4, 6).png(&[phys(17.4)]));
    save(folder.path(), "t/frames.csv", b"frame;um_per_px\na;17,45\n");
    for (files, options, code, words) in [
        (vec![&a], vec!["--um-per-px", "17.41"], 0, ""),
        (vec![&a], vec!["--um-per-px", "17.45"], 3, "a scale of 17.40"),
        (vec![&a], vec!["--um-per-px", "17.45", "--ignore-file-scale"], 0, ""),
        // A screen's resolution is no scale of the object.
        (vec![&screen], vec!["--um-per-px", "17.4"], 0, ""),
        (vec![&screen], vec!["--um-per-px", "file"], 3, "a screen's resolution, not a scale of the object"),
        (vec![&bare], vec!["--um-per-px", "file"], 3, "no scale in frames.csv"),
        (vec![&a, &b], vec!["--um-per-px", "file"], 0, "but the first frame's is 17.40"),
        (vec![&a, &bare], vec!["--um-per-px", "file"], 0, "frame bare: no scale"),
        (vec![&tabled], vec!["--um-per-px", "17.4"], 3, "frames.csv (row 2) is 17.450000"),
    ] {
        let paths: Vec<&Path> = files.iter().map(|p| p.as_path()).collect();
        let output = run(&paths, &[options.clone(), vec!["--json"]].concat());
        let told = said(&output);
        assert_eq!(output.status.code(), Some(code), "{options:?}: {told}");
        assert!(told.contains(words) && (told.is_empty() == words.is_empty()), "{options:?}: {told}");
    }
}
