//! Real input: back-lit washers with outer diameters from a coordinate-measuring machine. The
//! images are outside the project (`SHADOWGAUGE_WASHERS`); without them the test prints SKIPPED.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

#[path = "support/program.rs"]
mod program;

use std::path::{Path, PathBuf};

use serde_json::Value;

fn folder() -> Option<PathBuf> {
    let folder =
        std::env::var_os("SHADOWGAUGE_WASHERS").map(PathBuf::from).filter(|f| f.join("cmm.csv").is_file());
    if folder.is_none() {
        eprintln!("SKIPPED: SHADOWGAUGE_WASHERS names no folder with cmm.csv; the washers are not tested");
    }
    folder
}

fn measure(folder: &Path) -> Value {
    let output = program::shadowgauge(["measure".as_ref(), "--json".as_ref(), folder.as_os_str()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON on stdout")
}

/// Writes transposed copies, as from a camera turned by 90°.
fn transposed(folder: &Path, into: &Path) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "png") {
            let image = image::open(&path).unwrap().into_luma8();
            let turned =
                image::GrayImage::from_fn(image.height(), image.width(), |x, y| *image.get_pixel(y, x));
            turned.save(into.join(path.file_name().unwrap())).unwrap();
        }
    }
}

/// (part, outer_min_mm, outer_max_mm)
fn machine_values(folder: &Path) -> Vec<(u32, f64, f64)> {
    let mut csv = csv::Reader::from_path(folder.join("cmm.csv")).unwrap();
    let headers = csv.headers().unwrap().clone();
    let at = |name: &str| headers.iter().position(|h| h == name).unwrap();
    let (part, low, high) = (at("part"), at("outer_min_mm"), at("outer_max_mm"));
    csv.records()
        .map(|row| {
            let row = row.unwrap();
            (row[part].parse().unwrap(), row[low].parse().unwrap(), row[high].parse().unwrap())
        })
        .collect()
}

/// The largest caliper of every part, px; none where the frame is refused.
fn largest_px(measured: &Value) -> Vec<(u32, Option<f64>)> {
    measured["frames"]
        .as_array()
        .unwrap()
        .iter()
        .map(|f| (f["frame"].as_str().unwrap().parse().unwrap(), f["max_diameter_px"].as_f64()))
        .collect()
}

#[test]
fn washers_agree_with_the_measuring_machine() {
    let Some(folder) = folder() else { return };
    let turned = tempfile::tempdir().unwrap();
    transposed(&folder, turned.path());
    let (as_is, upright) = (measure(&folder), measure(turned.path()));
    for frame in as_is["frames"].as_array().unwrap().iter().chain(upright["frames"].as_array().unwrap()) {
        if frame["max_diameter_px"].is_null() {
            continue;
        }
        // The clipped bright field is flagged and measured; columns without a part or with steep
        // flanks are gaps.
        let columns = |flag: &str| frame["flags"][flag].as_u64().unwrap_or(0);
        // Where a burr or dirt lies along one edge, most columns are gaps.
        assert!(columns("clipped") > 100, "{frame}");
        assert!(columns("no_edge") + columns("steep") > 500, "{frame}");
        assert_eq!(frame["valid"], frame["flags"]["clipped"], "{frame}");
    }
    let machine = machine_values(&folder);
    let (a, b) = (largest_px(&as_is), largest_px(&upright));
    assert_eq!((a.len(), b.len(), machine.len()), (15, 15, 15));
    // An image with dirt or burrs may be refused in one orientation; the other one is then used for
    // the part.
    let refused = a.iter().chain(&b).filter(|part| part.1.is_none()).count();
    println!("{refused} of 30 pictures refused");
    assert!(refused <= 2, "{refused} of 30 pictures refused");
    let largest: Vec<f64> =
        a.iter().zip(&b).map(|(a, b)| a.1.into_iter().chain(b.1).reduce(f64::max).unwrap()).collect();
    // One common scale, from parts 1-22 alone: the middle of each part's band over its largest
    // caliper.
    let taught: Vec<f64> = machine
        .iter()
        .zip(&largest)
        .filter(|(m, _)| m.0 <= 22)
        .map(|((_, low, high), px)| 0.5 * (low + high) / px)
        .collect();
    let scale = taught.iter().sum::<f64>() / taught.len() as f64;
    println!("scale {:.5} um/px from {} parts", scale * 1e3, taught.len());
    let mut worst = f64::NEG_INFINITY;
    for (index, (part, low, high)) in machine.iter().enumerate() {
        let excess = |px: f64| 1e3 * (px * scale - high).max(low - px * scale);
        println!(
            "part {part:2}: largest {:.4} mm, beyond the machine's band by {:6.2} um (as it is {:6.2}, transposed {:6.2})",
            largest[index] * scale,
            excess(largest[index]),
            a[index].1.map_or(f64::NAN, excess),
            b[index].1.map_or(f64::NAN, excess)
        );
        worst = worst.max(excess(largest[index]));
    }
    println!("worst {worst:.2} um beyond the band");
    assert!(worst <= 6.0, "{worst} um");
}
