//! Own images with two pins to a table in mm, from outside and as an integrator goes about it:
//! images of 8 bits in common formats, with no table of ours beside them and no tag of ours in
//! them; the commented start of a calibration, edited as its comments say; a table in mm.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::path::Path;

use image::{GrayImage, ImageReader, Luma};

#[path = "support/program.rs"]
mod program;

/// True diameter of the part, mm.
const PART_MM: f64 = 11.2;
/// A day on which the start's calibration is valid.
const DAY: &str = "2026-06-01";

fn run(arguments: &[&str]) -> String {
    let output = program::shadowgauge(arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", program::said(&output));
    program::text(&output.stdout)
}

/// What stands between two texts.
fn between<'a>(text: &'a str, from: &str, to: &str) -> &'a str {
    let begins = text.find(from).expect(from);
    &text[begins..begins + text[begins..].find(to).expect(to)]
}

/// The frames of a folder as a camera of 8 bits gives them, under names of its own.
fn taken(rendered: &Path, folder: &Path, names: [&str; 2]) {
    std::fs::create_dir_all(folder).unwrap();
    for (index, name) in names.into_iter().enumerate() {
        let path = rendered.join(format!("{index:06}.png"));
        let wide = ImageReader::open(path).unwrap().decode().unwrap().into_luma16();
        let grey = |column, row| Luma([(wide.get_pixel(column, row).0[0] >> 4) as u8]);
        let image = GrayImage::from_fn(wide.width(), wide.height(), grey);
        image.save(folder.join(name)).unwrap();
    }
}

#[test]
fn own_images_with_two_pins_become_a_table_in_mm() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let start = run(&["new", "calibrate"]);
    // The camera: it sees both pins at two heights each, and a part.
    let part = format!("diameter_mm = {PART_MM}");
    std::fs::write(file("camera.toml"), start.replace("diameter_mm = 11.0", &part)).unwrap();
    run(&["render", &file("camera.toml"), "--out", &file("camera"), "--backend", "cpu"]);
    let camera = folder.path().join("camera");
    for (seen, own, names) in [
        ("pin_0_0", "ten low", ["Image 1.png", "Image 2.png"]),
        ("pin_0_1", "ten high", ["Image 9.png", "Image 10.png"]),
        ("pin_1_0", "twelve low", ["a.tif", "b.tif"]),
        ("pin_1_1", "twelve high", ["a.bmp", "b.bmp"]),
        ("pin_2_0", "part", ["first.png", "second.jpg"]),
    ] {
        taken(&camera.join(seen), &folder.path().join(own), names);
    }
    // "With a camera: delete [simulate] and name the folder of each recording"; without a third pin
    // there is no [check].
    let mut plan = start.replace(between(&start, "[check]", "# [fields]"), "");
    plan.truncate(plan.find("\n[simulate] ").expect("a table at the end"));
    for (height, own) in
        [("-1.0", "ten low"), ("1.0", "ten high"), ("-0.5", "twelve low"), ("0.5", "twelve high")]
    {
        let position = format!("{{ height_mm = {height} }}");
        assert!(plan.contains(&position), "{position} is not in the start");
        plan = plan.replace(&position, &format!("{{ frames = \"{own}\" }}"));
    }
    std::fs::write(file("my.toml"), plan).unwrap();
    let said = run(&["calibrate", &file("my.toml"), "--out", &file("my.json")]);
    assert!(said.contains("no check pin"), "{said}");
    let table = file("diameters.csv");
    run(&["measure", &file("part"), "--calibration", &file("my.json"), "--as-of", DAY, "--csv", &table]);
    let text = std::fs::read_to_string(&table).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    let column = |name: &str| rows[0].iter().position(|found| *found == name).expect(name);
    assert_eq!(rows.len(), 3, "{text}");
    for (row, name) in rows[1..].iter().zip(["first", "second"]) {
        let number = |name: &str| row[column(name)].parse::<f64>().unwrap();
        assert_eq!((row[column("frame")], row[column("refused")]), (name, ""));
        for (value, expanded) in [("diameter_mm", "expanded_u_mm"), ("mean_mm", "expanded_u_mean_mm")] {
            let (d_mm, u_mm) = (number(value), number(expanded));
            assert!((d_mm - PART_MM).abs() <= u_mm, "{name}: {value} = {d_mm}, U = {u_mm}");
            // A sixth of a pixel, 30 µm here: what is wider is not worth two pins.
            assert!(u_mm < 5e-3, "{name}: {expanded} = {u_mm}");
        }
    }
}
