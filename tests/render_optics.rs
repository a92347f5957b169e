//! Edge-spread families, defocus and the sensor against independent values.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

#[path = "support/render.rs"]
#[expect(dead_code, reason = "shared with the other tests of the renderer")]
mod support;

use std::f64::consts::{PI, TAU};

use shadowgauge::frame::PixelFormat;
use shadowgauge::render::coherence::edge_image;
use shadowgauge::render::esf::EsfTable;
use shadowgauge::render::fresnel::{straight_edge, straight_edge_in_band};
use shadowgauge::render::settings::{
    BenchSettings, Departures, Esf, FresnelEsf, GaussianEsf, PartiallyCoherentEsf, TableEsf,
};
use shadowgauge::render::{BackendChoice, FrameRequest, OpticalBench, RenderError, Renderer, Scene};
use shadowgauge::shaft::{AxisKnot, Shaft};
use support::*;

// ---- Fresnel

#[test]
fn fresnel_edge_meets_tabulated_integrals() {
    // C and S: Abramowitz & Stegun, table 7.7.
    let table = [
        (0.0, 0.0, 0.0),
        (0.5, 0.492_344_226, 0.064_732_433),
        (1.0, 0.779_893_400, 0.438_259_147),
        (2.0, 0.488_253_406, 0.343_415_678),
        (5.0, 0.563_631_189, 0.499_191_382),
    ];
    let (reach, count) = (10.0, 4000);
    let edge = straight_edge(reach, count);
    for (v, c, s) in table {
        for (sign, place) in [(1.0, v), (-1.0, -v)] {
            let expected: f64 =
                0.5 * ((0.5 + sign * c) * (0.5 + sign * c) + (0.5 + sign * s) * (0.5 + sign * s));
            let found = edge[((place + reach) / reach * count as f64).round() as usize];
            assert!((found - expected).abs() < 1e-7, "v = {place}: {found} {expected}");
        }
    }
    assert!((edge[count] - 0.25).abs() < 1e-12);
}

#[test]
fn fresnel_table_holds_the_curve_to_1e_5_and_its_half_is_where_it_should_be() {
    let esf = FresnelEsf { wavelength_nm: 650.0, bandwidth_nm: 0.0, distance_mm: 20.0 };
    let table = EsfTable::new(&Esf::Fresnel(esf), 0.005);
    let unit_px = (650e-6f64 * 20.0 / 2.0).sqrt() / 0.005;
    let (reach, count) = (10.0, 4000);
    let edge = straight_edge(reach, count);
    for (i, expected) in edge.iter().enumerate() {
        let v = reach * (i as f64 / count as f64 - 1.0);
        assert!((table.at_px(v * unit_px) - expected).abs() < 1e-5, "v = {v}");
    }
    let half = crossing(|v| table.at_px(v * unit_px));
    assert!((half - 0.354).abs() < 1e-3, "{half}");
}

#[test]
fn bandwidth_damps_the_far_fringes_and_leaves_the_edge() {
    let (reach, count) = (15.0, 3000);
    let (mono, band) = (straight_edge(reach, count), straight_edge_in_band(reach, count, 0.05));
    let ripple =
        |e: &[f64]| e[2 * count - 400..2 * count - 100].iter().map(|v| (v - 1.0).abs()).fold(0.0, f64::max);
    assert!(ripple(&band) < 0.1 * ripple(&mono), "{} {}", ripple(&band), ripple(&mono));
    assert!((band[count] - 0.25).abs() < 1e-4);
}

/// Where a rising edge first reaches a half.
fn crossing(f: impl Fn(f64) -> f64) -> f64 {
    let mut x = -1.0;
    while f(x) < 0.5 {
        x += 1e-3;
    }
    let (a, b) = (f(x - 1e-3), f(x));
    x - 1e-3 * (b - 0.5) / (b - a)
}

// ---- partially coherent

#[test]
fn partially_coherent_edge_has_the_published_values() {
    let (reach, count) = (4.0, 400);
    for (s, at_edge, half) in
        [(0.0, 0.25, 0.106), (0.5, 0.2573, 0.108), (1.0, 1.0 / 3.0, 0.0935), (1.5, 0.4334, 0.039)]
    {
        let image = edge_image(s, 0.0, reach, count);
        assert!((image[count] - at_edge).abs() < 5e-4, "S = {s}: {} at the edge", image[count]);
        let found = crossing(|x| sampled(&image, reach, x));
        assert!((found - half).abs() < 1e-3, "S = {s}: 50 % at {found}");
    }
    for (zeta, half) in [(1.0, 0.159), (2.0, 0.240)] {
        let image = edge_image(0.5, zeta, reach, count);
        let found = crossing(|x| sampled(&image, reach, x));
        assert!((found - half).abs() < 2e-3, "defocus {zeta}: 50 % at {found}");
    }
}

fn sampled(image: &[f64], reach: f64, x: f64) -> f64 {
    let place = (x / reach + 1.0) * ((image.len() - 1) / 2) as f64;
    let i = (place as usize).min(image.len() - 2);
    image[i] + (image[i + 1] - image[i]) * (place - i as f64)
}

/// The same image by another road: a grating of period `L` expanded in harmonics, the source in rings of equal area.
fn by_harmonics(s: f64, zeta: f64, x: f64) -> f64 {
    let period = 400.0;
    let (rings, around) = (40, 36);
    let (mut sum, mut full) = (0.0, 0.0);
    for i in 0..rings {
        for j in 0..around {
            let r = s * ((f64::from(i) + 0.5) / f64::from(rings)).sqrt();
            let (sin, cos) = (PI * (f64::from(j) + 0.5) / f64::from(around)).sin_cos();
            let (sx, sy) = (r * cos, r * sin);
            full += f64::from(u8::from(sx.hypot(sy) < 1.0));
            let (mut re, mut im) = (0.0, 0.0);
            let harmonics = (period * (1.0 + s)) as i32;
            for n in -harmonics..=harmonics {
                let f = f64::from(n) / period;
                let rho2 = (f + sx).powi(2) + sy * sy;
                if rho2 > 1.0 || (n % 2 == 0 && n != 0) {
                    continue;
                }
                // Light on 0..L/2: 1/2 at n = 0, 1/(iπn) at odd n.
                let phase = PI * zeta * rho2 + TAU * f * x;
                if n == 0 {
                    re += 0.5 * phase.cos();
                    im += 0.5 * phase.sin();
                } else {
                    re += phase.sin() / (PI * f64::from(n));
                    im -= phase.cos() / (PI * f64::from(n));
                }
            }
            sum += re * re + im * im;
        }
    }
    sum / full
}

#[test]
fn partially_coherent_edge_meets_a_second_integration() {
    let (reach, count) = (4.0, 400);
    let mut worst: f64 = 0.0;
    for (s, zeta) in [(0.3, 0.0), (0.7, 0.0), (1.0, 0.0), (0.5, 1.0)] {
        let image = edge_image(s, zeta, reach, count);
        for x in [-1.0, -0.3, 0.0, 0.1, 0.5, 1.3] {
            let difference = (sampled(&image, reach, x) - by_harmonics(s, zeta, x)).abs();
            worst = worst.max(difference);
            println!("S {s} defocus {zeta} x {x}: {difference:.1e}");
        }
    }
    println!("worst {worst:.1e} of full intensity");
    assert!(worst < 5e-4);
}

// ---- tables through the kernel

/// Worst error of a frame against the table integrated densely over every pixel of a level edge, in px.
fn kernel_error(esf: &Esf) -> f64 {
    let mut settings = BenchSettings { departures: Departures::none(), ..Default::default() };
    settings.camera.rows = 400;
    settings.camera.columns = 3;
    settings.optics.esf = esf.clone();
    let bench = OpticalBench::resolve(&settings, 0).unwrap();
    let scene = Scene::new(&bench, Shaft::cylinder(201.37 * bench.pixel_mm)).unwrap();
    let request = FrameRequest { format: Some(PixelFormat::F32), ..Default::default() };
    let frame = counts(&Renderer::new(BackendChoice::Cpu).unwrap().render(&scene, &request, None).unwrap());
    let edges = scene.geometric_edges(&request).unwrap()[1];
    let table = EsfTable::new(&bench.esf, bench.pixel_mm);
    let levels = scene.levels(PixelFormat::F32);
    let contrast = levels.bright - levels.shadow;
    let n = 200;
    let mut shift = [0.0, 0.0];
    for row in 0..400 {
        let light: f64 = (0..n)
            .map(|i| f64::from(row) + (f64::from(i) + 0.5) / f64::from(n) - 0.5)
            .map(|y| table.at_px(edges.top_px - y) + table.at_px(y - edges.bottom_px))
            .sum::<f64>()
            / f64::from(n);
        let found = (frame[row as usize * 3 + 1] - levels.shadow) / contrast;
        shift[usize::from(row >= 200)] += found - light;
    }
    shift[0].abs().max(shift[1].abs())
}

#[test]
fn kernel_integrates_every_family_over_the_pixel() {
    let table = TableEsf {
        distance_px: (-40..=40).map(|i| f64::from(i) * 0.2).collect(),
        light: (-40..=40).map(|i| 0.5 * libm::erfc(-f64::from(i) * 0.2 / 1.6)).collect(),
        may_ripple: false,
    };
    let coherent = PartiallyCoherentEsf::default();
    let laser = FresnelEsf { distance_mm: 5.0, bandwidth_nm: 40.0, ..Default::default() };
    for esf in [
        Esf::Gaussian(GaussianEsf::default()),
        Esf::PartiallyCoherent(coherent),
        Esf::Fresnel(laser),
        Esf::Table(table),
    ] {
        let error = kernel_error(&esf);
        println!("{error:.1e} px: {}", format!("{esf:?}").chars().take(40).collect::<String>());
        assert!(error < 1e-4, "{esf:?}: {error} px");
    }
}

#[test]
fn measured_edges_that_cannot_be_are_refused() {
    let good = TableEsf {
        distance_px: vec![-2.0, -1.0, 0.0, 1.0, 2.0],
        light: vec![0.0, 0.1, 0.5, 0.9, 1.0],
        may_ripple: false,
    };
    assert!(Esf::Table(good.clone()).check().is_ok());
    let spoiled: [fn(&mut TableEsf); 4] =
        [|t| t.light[2] = 0.95, |t| t.light[4] = 0.9, |t| t.distance_px[1] = -3.0, |t| t.light.truncate(3)];
    for spoil in spoiled {
        let mut t = good.clone();
        spoil(&mut t);
        let error = Esf::Table(t).check().unwrap_err();
        assert!(matches!(error, RenderError::Setting { .. }), "{error}");
    }
}

// ---- defocus

#[test]
fn an_edge_out_of_focus_is_blurred_by_half_the_aperture() {
    let bench = bench(200, 9, 1.0);
    let mut shaft = Shaft::cylinder(100.4 * bench.pixel_mm);
    shaft.deflection = vec![AxisKnot { z_mm: 0.0, x_mm: 0.0, y_mm: 3.0 }];
    let request = FrameRequest { format: Some(PixelFormat::F32), ..Default::default() };
    let twin = Renderer::new(BackendChoice::Cpu).unwrap();
    let scene = Scene::new(&bench, shaft).unwrap();
    let frame = counts(&twin.render(&scene, &request, None).unwrap());
    let levels = scene.levels(PixelFormat::F32);
    // Variance of the line spread along a column, the pixel's 1/12 taken off: σ² + (y·NA)²/4.
    let light: Vec<f64> =
        (0..100).map(|r| (frame[r * 9 + 4] - levels.shadow) / (levels.bright - levels.shadow)).collect();
    let spread: Vec<(f64, f64)> =
        light.windows(2).enumerate().map(|(r, w)| (r as f64 + 0.5, w[0] - w[1])).collect();
    let mean: f64 = spread.iter().map(|(x, w)| x * w).sum();
    let variance: f64 =
        spread.iter().map(|(x, w)| (x - mean).powi(2) * w).sum::<f64>() - 1.0 / 12.0 - 1.0 / 12.0;
    let expected = 1.0 + (3.0 * 0.02 / 2.0 / bench.pixel_mm).powi(2);
    // Differences of pixels put a second box of one pixel on the spread.
    assert!((variance / expected - 1.0).abs() < 2e-3, "{variance} {expected}");
    let edges = scene.geometric_edges(&request).unwrap()[4];
    assert!((light.iter().sum::<f64>() - 0.5 - edges.top_px).abs() < 1e-4, "defocus must not move the edge");
}

// ---- sensor: photon transfer after EMVA 1288

struct Flat {
    mean: f64,
    temporal: f64,
    spatial: f64,
}

/// Mean, temporal and spatial variance of a flat field of `bright` counts from `frames` frames.
fn flat_field(renderer: &Renderer, settings: &BenchSettings, bright: f64, frames: u64) -> Flat {
    let mut settings = settings.clone();
    settings.light.bright_counts = bright;
    let bench = OpticalBench::resolve(&settings, 5).unwrap();
    let scene = Scene::new(&bench, Shaft::cylinder(0.2)).unwrap();
    let (mut sum, mut squares) = (Vec::new(), Vec::new());
    for frame_id in 0..frames {
        let request = FrameRequest { frame_id, noise: true, seed: 3, ..Default::default() };
        let frame = counts(&renderer.render(&scene, &request, None).unwrap());
        let field = &frame[..bench.columns() * bench.rows() / 3];
        sum.resize(field.len(), 0.0);
        squares.resize(field.len(), 0.0);
        for ((s, q), v) in sum.iter_mut().zip(&mut squares).zip(field) {
            *s += v;
            *q += v * v;
        }
    }
    let (n, l) = (sum.len() as f64, frames as f64);
    let mean = sum.iter().sum::<f64>() / n / l;
    let temporal = sum.iter().zip(&squares).map(|(s, q)| (q - s * s / l) / (l - 1.0)).sum::<f64>() / n;
    let spatial = sum.iter().map(|s| (s / l - mean).powi(2)).sum::<f64>() / n - temporal / l;
    Flat { mean, temporal, spatial }
}

fn emva_bench() -> BenchSettings {
    let mut settings = BenchSettings { departures: Departures::none(), ..Default::default() };
    settings.camera.rows = 900;
    settings.camera.columns = 1200;
    settings.light.shadow_counts = 64.0;
    settings.sensor.prnu_rel = 0.012;
    settings.sensor.dsnu_e = 6.0;
    settings
}

/// Gain, read noise, PRNU, DSNU and linearity by photon transfer, each within 1 % of what was set.
fn photon_transfer(renderer: &Renderer) {
    let settings = emva_bench();
    let sensor = &settings.sensor;
    let dark = flat_field(renderer, &settings, sensor.black_level_counts, 24);
    let levels = [500.0, 1000.0, 1800.0, 2600.0];
    let flats: Vec<Flat> = levels.iter().map(|&b| flat_field(renderer, &settings, b, 12)).collect();
    // K: slope of the temporal variance over the mean, through the dark point, by least squares.
    let (xy, xx) = flats.iter().fold((0.0, 0.0), |(xy, xx), f| {
        let (x, y) = (f.mean - dark.mean, f.temporal - dark.temporal);
        (xy + x * y, xx + x * x)
    });
    let k = xy / xx;
    let read = (dark.temporal - 1.0 / 12.0).sqrt() / k;
    let brightest = &flats[3];
    let prnu = (brightest.spatial - dark.spatial).sqrt() / (brightest.mean - dark.mean);
    let dsnu = dark.spatial.sqrt() / k;
    for (name, found, set) in [
        ("electrons per count", 1.0 / k, sensor.electrons_per_count),
        ("read noise", read, sensor.read_noise_e),
        ("PRNU", prnu, sensor.prnu_rel),
        ("DSNU", dsnu, sensor.dsnu_e),
    ] {
        println!("{name}: {found:.4} for {set}");
        assert!((found / set - 1.0).abs() < 0.01, "{name}: {found} for {set}");
    }
    for (flat, level) in flats.iter().zip(levels) {
        assert!((flat.mean / level - 1.0).abs() < 1e-3, "linearity: {} for {level}", flat.mean);
    }
}

#[test]
fn photon_transfer_of_the_twin_gives_back_the_sensor() {
    photon_transfer(&Renderer::new(BackendChoice::Cpu).unwrap());
}

#[test]
fn photon_transfer_of_the_device_gives_back_the_sensor() {
    let Some(device) = device() else { return };
    photon_transfer(&device);
}

#[test]
fn full_well_clips_and_hot_pixels_stay() {
    let mut settings = emva_bench();
    settings.sensor.full_well_e = 5000.0;
    settings.sensor.hot_pixels_ppm = 500.0;
    let twin = Renderer::new(BackendChoice::Cpu).unwrap();
    let clipped = flat_field(&twin, &settings, 3500.0, 2);
    let ceiling = 64.0 + 5000.0 / 2.6;
    assert!((clipped.mean - ceiling).abs() < 1.0 && clipped.temporal < 1e-6, "{}", clipped.mean);
    settings.light.bright_counts = 64.0;
    let dark = OpticalBench::resolve(&settings, 5).unwrap();
    let scene = Scene::new(&dark, Shaft::cylinder(0.2)).unwrap();
    let hot = |frame_id| -> Vec<usize> {
        let request = FrameRequest { frame_id, noise: true, ..Default::default() };
        let frame = counts(&twin.render(&scene, &request, None).unwrap());
        frame.iter().enumerate().filter(|(_, v)| **v > 400.0).map(|(i, _)| i).collect()
    };
    let (first, second) = (hot(0), hot(1));
    assert_eq!(first, second, "hot pixels move");
    let expected = 900.0 * 1200.0 * 500e-6;
    assert!((first.len() as f64 - expected).abs() < 4.0 * f64::sqrt(expected), "{}", first.len());
}
