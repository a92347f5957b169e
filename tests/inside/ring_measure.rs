//! Rings seen end-on: frames from a renderer in this file, and real washers compared with a
//! coordinate-measuring machine.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use crate::inside::support::program;

use std::f64::consts::TAU;
use std::path::PathBuf;

use glam::DVec2;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use shadowgauge::frame::{Buffer, Frame, FrameMeta, PixelFormat};
use shadowgauge::gauge::calibration::{
    Adjusted, Conditions, CovariancePart, LensModel, SetupCalibration, Validity,
};
use shadowgauge::gauge::ring::{RingError, RingMeasurement, RingScale, RingSettings, measure_ring};
use shadowgauge::gauge::{Calibration, MasterCertificate, MasterFigure};

/// Share of a Gaussian-blurred disc's shadow at distance ρ from its centre, by lines across the
/// disc.
fn blurred_disc(rho: f64, radius: f64, sigma: f64) -> f64 {
    let cdf = |t: f64| 0.5 * libm::erfc(-t * std::f64::consts::FRAC_1_SQRT_2);
    let h = 0.05;
    (-140..=140)
        .map(|i| {
            let t = f64::from(i) * h;
            let half = radius * radius - (t * sigma).powi(2);
            let weight = h * (-0.5 * t * t).exp() / TAU.sqrt();
            if half <= 0.0 {
                0.0
            } else {
                weight * (cdf((half.sqrt() - rho) / sigma) - cdf((-half.sqrt() - rho) / sigma))
            }
        })
        .sum()
}

/// The blurred disc over ρ − R, tabulated finely.
struct Table {
    radius: f64,
    values: Vec<f64>,
}

const STEP: f64 = 0.005;
const REACH: f64 = 14.0;

impl Table {
    fn new(radius: f64, sigma: f64) -> Self {
        let n = (2.0 * REACH / STEP) as usize;
        Self {
            radius,
            values: (0..=n).map(|i| blurred_disc(radius - REACH + STEP * i as f64, radius, sigma)).collect(),
        }
    }

    fn at(&self, rho: f64) -> f64 {
        let t = (rho - self.radius + REACH) / STEP;
        if t <= 0.0 {
            return 1.0;
        }
        let k = t as usize;
        if k + 1 >= self.values.len() {
            return 0.0;
        }
        self.values[k] + (t - k as f64) * (self.values[k + 1] - self.values[k])
    }
}

/// A ring to be drawn.
#[derive(Clone, Copy)]
struct Ring {
    outer: f64,
    inner: f64,
    centre: DVec2,
    bore_shift: DVec2,
    lobes: (f64, f64),
    sigma: f64,
    levels: (f64, f64),
    tilt: f64,
    noise: f64,
}

const RING: Ring = Ring {
    outer: 140.3,
    inner: 81.7,
    centre: DVec2::new(170.37, 161.81),
    bore_shift: DVec2::new(0.25, -0.4),
    lobes: (3.0, 0.0),
    sigma: 1.1,
    levels: (14.0, 200.0),
    tilt: 0.0,
    noise: 1.0,
};

/// Mean grey values, by 6 x 6 points per pixel.
fn expected(ring: &Ring, size: (usize, usize)) -> Vec<f64> {
    let (outer, inner) = (Table::new(ring.outer, ring.sigma), Table::new(ring.inner, ring.sigma));
    let parts = 6;
    let sub = |i: i32| (f64::from(i) + 0.5) / f64::from(parts) - 0.5;
    let mut counts = Vec::new();
    for row in 0..size.0 {
        for column in 0..size.1 {
            let mut shadow = 0.0;
            for i in 0..parts {
                for j in 0..parts {
                    let p = DVec2::new(column as f64 + sub(i), row as f64 + sub(j)) - ring.centre;
                    let lobe = if ring.lobes.1 > 0.0 {
                        ring.lobes.1 * (ring.lobes.0 * p.y.atan2(p.x)).cos()
                    } else {
                        0.0
                    };
                    shadow += outer.at(p.length() - lobe) - inner.at((p - ring.bore_shift).length());
                }
            }
            let light = ring.levels.1 * (1.0 + ring.tilt * (column as f64 / size.1 as f64 - 0.5));
            counts.push(light - (light - ring.levels.0) * shadow / f64::from(parts * parts));
        }
    }
    counts
}

fn expose(expected: &[f64], noise: f64, size: (usize, usize), format: PixelFormat, seed: u64) -> Frame {
    let mut random = Pcg64::seed_from_u64(seed);
    let normal = rand_distr::Normal::new(0.0, noise.max(1e-12)).unwrap();
    let counts: Vec<f64> = expected.iter().map(|mean| mean + random.sample(normal)).collect();
    let full = format.full_scale().map_or(f64::INFINITY, f64::from);
    let buffer = match format {
        PixelFormat::F32 => Buffer::F32(counts.iter().map(|v| *v as f32).collect()),
        _ => Buffer::U8(counts.iter().map(|v| v.round().clamp(0.0, full) as u8).collect()),
    };
    Frame::new(buffer, format, size.0, size.1, FrameMeta::default()).unwrap()
}

fn draw(ring: &Ring, size: (usize, usize), format: PixelFormat, seed: u64) -> Frame {
    expose(&expected(ring, size), ring.noise, size, format, seed)
}

const SIZE: (usize, usize) = (324, 340);

fn errors(ring: &Ring, found: &RingMeasurement) -> (f64, f64) {
    let bore = found.inner.as_ref().unwrap();
    (found.outer.diameter_px - 2.0 * ring.outer, bore.diameter_px - 2.0 * ring.inner)
}

#[test]
fn diameters_of_noiseless_rings_are_right_to_a_thousandth_of_a_pixel() {
    for (sigma, outer, inner) in
        [(0.6, 140.3, 81.7), (1.1, 140.3, 81.7), (1.8, 60.2, 30.4), (1.5, 40.15, 20.35)]
    {
        let ring = Ring { sigma, outer, inner, noise: 0.0, centre: DVec2::new(170.37, 161.81), ..RING };
        let found =
            measure_ring(&draw(&ring, SIZE, PixelFormat::F32, 1).view(), &RingSettings::default()).unwrap();
        let (out, bore) = errors(&ring, &found);
        println!(
            "sigma {sigma}, R {outer}, {inner}: errors {out:+.5}, {bore:+.5} px, blur {:.4}",
            found.outer.sigma_px
        );
        assert!(out.abs() < 1e-3 && bore.abs() < 1e-3);
        assert!((found.outer.sigma_px - sigma).abs() < 5e-3);
        let c = found.concentricity.unwrap();
        assert!((c.px - 2.0 * ring.bore_shift.length()).abs() < 1e-3, "{}", c.px);
        assert!(DVec2::from(found.outer.centre_px).distance(ring.centre) < 1e-3);
    }
}

#[test]
fn a_clipped_bright_field_and_a_tilt_of_the_light_leave_no_bias() {
    // Full scale at 73 % of the light, as in the washers.
    let clipped = Ring { levels: (18.0, 340.0), sigma: 1.5, noise: 1.5, ..RING };
    let tilted = Ring { tilt: 0.08, ..RING };
    for (name, ring) in [("clipped", clipped), ("tilted", tilted)] {
        let found =
            measure_ring(&draw(&ring, SIZE, PixelFormat::Mono8, 2).view(), &RingSettings::default()).unwrap();
        let (out, bore) = errors(&ring, &found);
        println!(
            "{name}: errors {out:+.5}, {bore:+.5} px, u {:.5}, light {:.1}",
            found.outer.u_diameter_px, found.outer.levels[1]
        );
        assert!(out.abs() < 4.0 * found.outer.u_diameter_px + 1e-3, "{name} {out}");
        assert!(bore.abs() < 4.0 * found.inner.as_ref().unwrap().u_diameter_px + 1e-3, "{name} {bore}");
    }
}

#[test]
fn the_stated_uncertainty_is_the_scatter_of_the_diameters() {
    for format in [PixelFormat::F32, PixelFormat::Mono8] {
        let ring = Ring { outer: 60.2, inner: 30.4, centre: DVec2::new(72.3, 70.6), noise: 3.0, ..RING };
        let (size, mut squares, mut stated, runs) = ((142, 146), [0.0; 2], [0.0; 2], 60);
        let mean = expected(&ring, size);
        for seed in 0..runs {
            let frame = expose(&mean, ring.noise, size, format, 100 + seed);
            let found = measure_ring(&frame.view(), &RingSettings::default()).unwrap();
            let (out, bore) = errors(&ring, &found);
            for (k, e) in [out, bore].into_iter().enumerate() {
                squares[k] += e * e / runs as f64;
            }
            stated[0] += found.outer.u_diameter_px.powi(2) / runs as f64;
            stated[1] += found.inner.unwrap().u_diameter_px.powi(2) / runs as f64;
        }
        for k in 0..2 {
            let ratio = (stated[k] / squares[k]).sqrt();
            println!(
                "{format:?} edge {k}: rms(u)/rms(error) = {ratio:.3}, rms error {:.5} px",
                squares[k].sqrt()
            );
            // 60 runs: the ratio itself scatters by 9 %.
            assert!((0.75..1.35).contains(&ratio), "{ratio}");
        }
    }
}

#[test]
fn lobes_show_as_roundness_and_a_burr_does_not_move_the_circle() {
    let ring = Ring { lobes: (3.0, 0.2), ..RING };
    let frame = draw(&ring, SIZE, PixelFormat::Mono8, 3);
    let clean = measure_ring(&frame.view(), &RingSettings::default()).unwrap();
    assert!((clean.outer.roundness_px - 0.4).abs() < 0.03, "{}", clean.outer.roundness_px);
    assert!(clean.inner.as_ref().unwrap().roundness_px < 0.05);
    let Buffer::U8(mut pixels) = frame.into_buffer() else { panic!("8 bit") };
    // Chips: a block of 7 px outside at the right, one inside the bore at the bottom, a speck on
    // its own.
    for (row, column) in [(158, 309), (240, 165), (20, 20)] {
        for r in row..row + 7 {
            for c in column..column + 7 {
                pixels[r * SIZE.1 + c] = 14;
            }
        }
    }
    let frame =
        Frame::new(Buffer::U8(pixels), PixelFormat::Mono8, SIZE.0, SIZE.1, FrameMeta::default()).unwrap();
    let dirty = measure_ring(&frame.view(), &RingSettings::default()).unwrap();
    let moved = (dirty.outer.diameter_px - clean.outer.diameter_px).abs();
    println!(
        "chips: {} and {} calipers refused, moved by {moved:.5} px",
        dirty.outer.refused,
        dirty.inner.as_ref().unwrap().refused
    );
    assert!(dirty.outer.refused >= 2 && dirty.outer.refused < 30 && moved < 0.01);
    assert!((dirty.inner.unwrap().diameter_px - clean.inner.unwrap().diameter_px).abs() < 0.01);
}

#[test]
fn a_scale_gives_millimetres_and_flat_keys() {
    let scale =
        RingScale { um_per_px: 20.0, u_um_per_px: 0.002, edge_offset_px: 0.25, u_edge_offset_px: 0.01 };
    let settings = RingSettings { scale: Some(scale), ..RingSettings::default() };
    let found = measure_ring(&draw(&RING, SIZE, PixelFormat::Mono8, 4).view(), &settings).unwrap();
    let outer = found.outer.mm.unwrap();
    assert!((outer.diameter_mm - 0.02 * (found.outer.diameter_px + 0.5)).abs() < 1e-12);
    let expected = (outer.diameter_mm * 1e-4).hypot(2.0 * 0.02 * 0.01);
    assert!((outer.u_common_mm - expected).abs() < 1e-9 && outer.u_diameter_mm >= outer.u_common_mm);
    let bore = found.inner.as_ref().unwrap();
    assert!((bore.mm.unwrap().diameter_mm - 0.02 * (bore.diameter_px - 0.5)).abs() < 1e-12);
    let json = found.to_json();
    for key in [
        "outer_diameter_px",
        "inner_diameter_px",
        "outer_diameter_mm",
        "inner_diameter_mm",
        "u_outer_diameter_px",
        "u_inner_diameter_mm",
        "roundness_outer_px",
        "roundness_inner_mm",
        "concentricity_px",
        "concentricity_mm",
    ] {
        assert!(json[key].is_number(), "{key} in {json}");
    }
    // A disc has no bore.
    let disc = Ring { inner: 1e-3, ..RING };
    let found =
        measure_ring(&draw(&disc, SIZE, PixelFormat::Mono8, 5).view(), &RingSettings::default()).unwrap();
    assert!(found.inner.is_none() && (found.outer.diameter_px - 280.6).abs() < 0.02);
}

#[test]
fn frames_without_a_ring_are_refused_with_a_reason() {
    let settings = RingSettings::default();
    let frame = |value: &dyn Fn(usize, usize) -> f32| {
        let pixels = (0..SIZE.0 * SIZE.1).map(|i| value(i / SIZE.1, i % SIZE.1)).collect();
        Frame::new(Buffer::F32(pixels), PixelFormat::F32, SIZE.0, SIZE.1, FrameMeta::default()).unwrap()
    };
    let measure = |f: &Frame| measure_ring(&f.view(), &settings).unwrap_err();
    assert!(matches!(measure(&frame(&|_, _| 100.0)), RingError::LowContrast { .. }));
    assert!(matches!(
        measure(&frame(&|r, _| if r == 7 { f32::NAN } else { 1.0 })),
        RingError::NotFinite { row: 7, .. }
    ));
    let shaft = |r: usize, _: usize| if (100..200).contains(&r) { 10.0 } else { 200.0 };
    assert!(matches!(measure(&frame(&shaft)), RingError::NoPart { found: 1, .. }));
    let square =
        |r: usize, c: usize| if (80..240).contains(&r) && (80..240).contains(&c) { 10.0 } else { 200.0 };
    assert!(matches!(measure(&frame(&square)), RingError::NotRound { .. }));
    let mut random = Pcg64::seed_from_u64(9);
    let normal = rand_distr::Normal::new(100.0, 20.0).unwrap();
    let noise: Vec<f32> = (0..SIZE.0 * SIZE.1).map(|_| random.sample::<f64, _>(normal) as f32).collect();
    assert!(matches!(measure(&frame(&|r, c| noise[r * SIZE.1 + c])), RingError::LowContrast { .. }));
    // Whether or not the one pixel is among those from which the levels are estimated.
    let speck = measure(&frame(&|r, c| if (r, c) == (10, 10) { 0.0 } else { 200.0 }));
    let flat = matches!(speck, RingError::LowContrast { contrast, .. } if contrast == 0.0);
    assert!(flat || matches!(speck, RingError::NoPart { .. }), "{speck}");
    let bad = RingSettings { calipers: 3, ..RingSettings::default() };
    assert!(matches!(
        measure_ring(&frame(&shaft).view(), &bad),
        Err(RingError::Setting(e)) if e.key == "ring.calipers"
    ));
}

// ------------------------------------------------------------------------------------------------
// Calibration

/// The ring imaged by a lens.
fn ring_through(lens: &LensModel) -> Frame {
    let (outer, inner) = (Table::new(RING.outer, RING.sigma), Table::new(RING.inner, RING.sigma));
    // Every pixel shows the position that the lens maps to it, averaged over its area.
    let parts = 6;
    let sub = |i: i32| (f64::from(i) + 0.5) / f64::from(parts) - 0.5;
    let mut counts = Vec::new();
    for row in 0..SIZE.0 {
        for column in 0..SIZE.1 {
            let mut shadow = 0.0;
            for (i, j) in (0..parts).flat_map(|i| (0..parts).map(move |j| (i, j))) {
                let p = DVec2::from(lens.ideal_point([column as f64 + sub(i), row as f64 + sub(j)]))
                    - RING.centre;
                shadow += outer.at(p.length()) - inner.at((p - RING.bore_shift).length());
            }
            counts.push(200.0 - 186.0 * shadow / f64::from(parts * parts));
        }
    }
    expose(&counts, 0.0, SIZE, PixelFormat::F32, 1)
}

/// Calibrations of scale and offset alone, and with the lens.
fn calibrations(lens: LensModel) -> (Calibration, Calibration) {
    let certificate = MasterCertificate { diameter_mm: 1.0, expanded_u_mm: 1e-4, coverage_factor: 2.0 };
    let figure = |width_px: f64| MasterFigure {
        certificate: MasterCertificate { diameter_mm: 0.02 * width_px + 0.01, ..certificate },
        width_px,
        u_width_px: 0.0,
    };
    let plain = Calibration::fit_figures(&[figure(160.0), figure(280.0)]).unwrap();
    let mut matrix = [[0.0; 6]; 6];
    matrix[0][0] = 1e-12;
    let part = CovariancePart { source: "certificates".into(), matrix };
    let mut distortion = [[0.0; 6]; 6];
    distortion[2][2] = 1e-8;
    let adjusted = Adjusted {
        parameters: [0.02, 0.01, lens.radial, lens.keystone_across, lens.keystone_along, 0.0],
        lens,
        parts: vec![part, CovariancePart { source: "distortion".into(), matrix: distortion }],
        birge_ratio: 1.0,
        residuals: Vec::new(),
    };
    let validity = Validity { date: "2026-01-01".parse().unwrap(), valid_days: 365 };
    let setup = SetupCalibration::new(&adjusted, SIZE, validity, RING.sigma);
    let full = Calibration::of_setup(&adjusted, plain.masters.clone(), setup);
    (plain, full)
}

/// A lens that distorts as `LensModel`: the drawn ring is warped by its inverse.
#[test]
fn a_calibration_takes_distortion_and_keystone_out_of_a_ring() {
    let lens = LensModel {
        radial: 2e-3,
        keystone_across: 8e-4,
        keystone_along: -5e-4,
        ..LensModel::perfect(SIZE.0, SIZE.1)
    };
    let frame = ring_through(&lens);
    let mut found = measure_ring(&frame.view(), &RingSettings::default()).unwrap();
    let seen = found.clone();
    let (plain, full) = calibrations(lens);
    let warm = Conditions { temperature_c: 30.0, ..Conditions::default() };
    found.calibrate(&full, &warm, 50.0).unwrap();
    let (out, bore) = (found.outer.mm.unwrap(), found.inner.as_ref().unwrap().mm.unwrap());
    let at_20 = warm.to_reference();
    let wanted = [(0.04 * RING.outer + 0.01) * at_20, (0.04 * RING.inner - 0.01) * at_20];
    let left = [0.04 * RING.outer + 0.01, 0.04 * RING.inner - 0.01];
    let mut bare = seen;
    bare.calibrate(&plain, &Conditions::default(), 50.0).unwrap();
    let off = [
        bare.outer.mm.unwrap().diameter_mm - left[0],
        bare.inner.as_ref().unwrap().mm.unwrap().diameter_mm - left[1],
    ];
    let errors = [out.diameter_mm - wanted[0], bore.diameter_mm - wanted[1]].map(|e| 1e3 * e);
    println!("errors {errors:?} um; with scale and offset alone {:?} um", off.map(|e| 1e3 * e));
    assert!(errors.iter().all(|e| e.abs() < 0.03) && off[0].abs() > 3e-4);
    // Roundness of a round part: the contribution of the lens is removed.
    let before = 20.0 * bare.outer.roundness_px;
    println!("roundness {:.3} um, as seen {before:.3} um", 1e3 * out.roundness_mm);
    assert!(1e3 * out.roundness_mm < 0.2 * before);
    let apart = 0.04 * RING.bore_shift.length() * at_20;
    assert!((found.concentricity.unwrap().mm.unwrap() - apart).abs() < 3e-5);
    // Scale 5e-5 relative; distortion 1e-4 of r^2/rho^2 at the outline.
    let d = 2.0 * RING.outer;
    let rho = 0.5 * (SIZE.0 as f64).hypot(SIZE.1 as f64);
    let by_distortion = 0.02 * d * (RING.outer / rho).powi(2) * 1e-4;
    let u = (d * 1e-6).hypot(by_distortion);
    assert!((out.u_common_mm / u - 1.0).abs() < 0.1, "{} {u}", out.u_common_mm);
    assert!(
        (bare.outer.mm.unwrap().u_common_mm / plain.u_common_mm(bare.outer.diameter_px) - 1.0).abs() < 1e-6
    );
}

// ------------------------------------------------------------------------------------------------
// Real washers

#[test]
fn washers_agree_with_the_coordinate_measuring_machine_no_worse_than_a_level_crossing() {
    let set = std::env::var_os("SHADOWGAUGE_WASHERS").map(PathBuf::from);
    let Some(folder) = set.filter(|f| f.join("cmm.csv").is_file()) else {
        eprintln!("SKIPPED: SHADOWGAUGE_WASHERS names no folder with cmm.csv; the washers are not tested");
        return;
    };
    let out = tempfile::tempdir().unwrap();
    let run = |extra: &[&str]| {
        let words = ["study", "washers", folder.to_str().unwrap()];
        program::shadowgauge(words.iter().chain(extra))
    };
    let done = run(&["--json", "--out", out.path().join("w").to_str().unwrap()]);
    let json: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    let study = &json["washers"];
    let spread = |method: &serde_json::Value| {
        let at = |key: &str, side: usize| method[key][side].as_f64().unwrap();
        [at("sd_um", 0), at("robust_sd_um", 0), at("sd_um", 1), at("robust_sd_um", 1)]
    };
    let (ours, level) = (spread(&study["ours"]), spread(&study["level_crossing"]));
    println!("outer sd, robust, inner sd, robust / um: ours {ours:.2?}, level crossing {level:.2?}");
    println!("optical edge, burrs refused {:.2?}", spread(&study["optical"]));
    for ball in study["balls"].as_array().unwrap() {
        println!("{} {:.2?}", ball["name"], spread(ball));
    }
    assert!(ours.iter().zip(&level).all(|(a, b)| a <= b));
    assert_eq!((done.status.code(), json["misses"].as_array().map(Vec::len)), (Some(0), Some(0)));
    let outliers = study["outliers"].as_array().unwrap();
    assert!(!outliers.is_empty());
    for outlier in outliers {
        let name = outlier["name"].as_str().unwrap();
        let side = ["outer", "inner"][outlier["side"].as_u64().unwrap() as usize];
        println!("outlier {name} {side} {}", outlier["residual_um"]);
        let svg = out.path().join("w").join(format!("{}_{side}.svg", name.trim_end_matches(".png")));
        assert!(std::fs::read_to_string(svg).unwrap().contains("data:image/png"));
    }
}

#[test]
fn the_washers_study_names_what_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let run = || {
        let done = program::shadowgauge(["study", "washers", folder.path().to_str().unwrap()]);
        (done.status.code(), program::text(&done.stderr))
    };
    let (code, text) = run();
    assert!(code == Some(3) && text.contains("cmm.csv"), "{text}");
    std::fs::write(folder.path().join("cmm.csv"), "part,outer_diameter_mm\n1,20\n").unwrap();
    let (code, text) = run();
    assert!(code == Some(3) && text.contains("inner_diameter_mm"), "{text}");
    std::fs::write(folder.path().join("cmm.csv"), "part,outer_diameter_mm,inner_diameter_mm\n1,20,x\n")
        .unwrap();
    let (code, text) = run();
    assert!(code == Some(3) && text.contains("a number above 0"), "{text}");
    std::fs::write(folder.path().join("cmm.csv"), "part,outer_diameter_mm,inner_diameter_mm\n1,20,10\n")
        .unwrap();
    image::GrayImage::new(64, 64).save(folder.path().join("0001.png")).unwrap();
    let (code, text) = run();
    assert!(code == Some(2) && text.contains("1 parts"), "{text}");
}
