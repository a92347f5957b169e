//! Temporal noise on flat fields: four moments and neighbours, against Poisson + Gaussian.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use crate::inside::support::render as support;

use shadowgauge::frame::{PixelFormat, Roi};
use shadowgauge::render::settings::{DarkCurrent, SetupDeviations, SetupSettings};
use shadowgauge::render::shadowgraph::standard_normal;
use shadowgauge::render::{BackendChoice, FrameRequest, OpticalSetup, Renderer, Scene};
use shadowgauge::shaft::Shaft;
use support::counts;

/// Pixels of a sample.
const SAMPLE: usize = 10_000_000;

/// Every value of the triangular sum with its probability and its deviate.
fn all_deviates() -> impl Iterator<Item = (f64, f64)> {
    (0..=131_070u32).map(|sum| {
        let high = sum.min(65_535);
        let probability = (65_536.0 - (f64::from(sum) - 65_535.0).abs()) / 2f64.powi(32);
        (probability, f64::from(standard_normal(high << 16 | (sum - high))))
    })
}

#[test]
fn deviates_of_all_hashes_have_the_normal_moments() {
    let moment = |k: i32| all_deviates().map(|(p, z)| p * z.powi(k)).sum::<f64>();
    assert!((moment(0) - 1.0).abs() < 1e-12);
    assert!(moment(1).abs() < 1e-9 && moment(3).abs() < 1e-9);
    assert!((moment(2) - 1.0).abs() < 1e-6, "{}", moment(2));
    assert!((moment(4) - 3.0).abs() < 1e-5, "{}", moment(4));
    assert!((moment(6) - 15.0).abs() < 0.02, "{}", moment(6));
}

#[test]
fn deviates_follow_the_normal_distribution() {
    let mut below = 0.0;
    let mut worst: f64 = 0.0;
    for (p, z) in all_deviates() {
        let phi = 0.5 * libm::erfc(-z / std::f64::consts::SQRT_2);
        worst = worst.max((below + 0.5 * p - phi).abs());
        below += p;
    }
    println!("distribution function off by {worst:.2e}");
    assert!(worst < 4e-4);
    let largest = all_deviates().map(|(_, z)| z).fold(0.0, f64::max);
    assert!(largest > 5.0, "{largest}");
}

/// Central moments and neighbour correlations of a sample laid out in rows.
struct Moments {
    mean: f64,
    variance: f64,
    third: f64,
    fourth: f64,
    right: f64,
    below: f64,
}

fn moments(rows: &[Vec<f64>]) -> Moments {
    let n = rows.iter().map(Vec::len).sum::<usize>() as f64;
    let mean = rows.iter().flatten().sum::<f64>() / n;
    let central = |p: i32| rows.iter().flatten().map(|v| (v - mean).powi(p)).sum::<f64>() / n;
    let variance = central(2);
    let right: f64 = rows.iter().flat_map(|r| r.windows(2)).map(|w| (w[0] - mean) * (w[1] - mean)).sum();
    let below: f64 =
        rows.windows(2).flat_map(|w| w[0].iter().zip(&w[1])).map(|(a, b)| (a - mean) * (b - mean)).sum();
    Moments {
        mean,
        variance,
        third: central(3),
        fourth: central(4),
        right: right / n / variance,
        below: below / n / variance,
    }
}

/// Rows of flat field: the bright field where `bright`, otherwise the shadow.
fn sample(renderer: &Renderer, bright: bool, format: PixelFormat) -> (Vec<Vec<f64>>, Expected) {
    let mut settings = SetupSettings { departures: SetupDeviations::none(), ..Default::default() };
    settings.camera.rows = 2048;
    settings.light.shadow_counts = 80.0;
    let setup = OpticalSetup::resolve(&settings, 0).unwrap();
    // A wire for the bright field, a shaft that fills the frame for the shadow.
    let scene = Scene::new(&setup, Shaft::cylinder(if bright { 0.5 } else { 30.0 })).unwrap();
    let columns = setup.columns();
    let mut rows = Vec::new();
    let mut frame_id = 0;
    while rows.len() * columns < SAMPLE {
        let request =
            FrameRequest { frame_id, noise: true, seed: 77, format: Some(format), ..Default::default() };
        let frame = renderer.render(&scene, &request, None).unwrap();
        let all = counts(&frame);
        let keep = if bright { 0..900 } else { 200..1800 };
        rows.extend(
            all.chunks_exact(columns).enumerate().filter(|(r, _)| keep.contains(r)).map(|(_, v)| v.to_vec()),
        );
        frame_id += 1;
    }
    let levels = scene.setup().levels(format);
    let mean = if bright { levels.bright } else { levels.shadow };
    let electrons = (mean - levels.black) * levels.electrons_per_count;
    (
        rows,
        Expected {
            mean,
            electrons,
            read: levels.read_noise_e,
            per_count: levels.electrons_per_count,
            rounded: format != PixelFormat::F32,
        },
    )
}

/// Poisson electrons with Gaussian read noise, in counts.
struct Expected {
    mean: f64,
    electrons: f64,
    read: f64,
    per_count: f64,
    rounded: bool,
}

fn judge(name: &str, rows: &[Vec<f64>], expected: &Expected) {
    let n = rows.iter().map(Vec::len).sum::<usize>() as f64;
    let m = moments(rows);
    let k = 1.0 / expected.per_count;
    let rounding = if expected.rounded { 1.0 / 12.0 } else { 0.0 };
    let variance = k * k * (expected.read.powi(2) + expected.electrons) + rounding;
    let third = k.powi(3) * expected.electrons;
    // Fourth cumulant of Poisson electrons, and -1/120 of the rounding.
    let fourth = 3.0 * variance * variance + k.powi(4) * expected.electrons - rounding / 10.0;
    let sd = variance.sqrt();
    let checks = [
        ("mean", m.mean - expected.mean, sd / n.sqrt()),
        ("variance", m.variance - variance, variance * (2.0 / n).sqrt()),
        ("third moment", m.third - third, variance.powf(1.5) * (15.0f64 - 9.0).sqrt() / n.sqrt()),
        (
            "fourth moment",
            m.fourth - fourth,
            variance * variance * (24.0 / n).sqrt() + 6.0 * variance * variance * (2.0 / n).sqrt(),
        ),
        ("right neighbour", m.right, 1.0 / n.sqrt()),
        ("lower neighbour", m.below, 1.0 / n.sqrt()),
    ];
    for (what, departure, error) in checks {
        println!("{name}: {what} off by {departure:.3e}, {:.2} standard errors", departure / error);
        assert!(
            departure.abs() < 3.0 * error,
            "{name}: {what} off by {:.1} standard errors",
            departure / error
        );
    }
    let kurtosis = m.fourth / (m.variance * m.variance) - fourth / (variance * variance);
    println!("{name}: kurtosis off by {:.2} standard errors", kurtosis / (24.0 / n).sqrt());
    assert!(kurtosis.abs() < 3.0 * (24.0 / n).sqrt(), "{name}: kurtosis {kurtosis}");
}

#[test]
fn twin_noise_has_the_moments_of_poisson_and_gaussian() {
    let twin = Renderer::new(BackendChoice::Cpu).unwrap();
    for (name, bright, format) in [
        ("bright, 12 bit", true, PixelFormat::Mono12),
        ("shadow, 12 bit", false, PixelFormat::Mono12),
        ("shadow, unquantised", false, PixelFormat::F32),
    ] {
        let (rows, expected) = sample(&twin, bright, format);
        judge(name, &rows, &expected);
    }
}

#[test]
fn device_noise_has_the_moments_of_poisson_and_gaussian() {
    let Some(device) = support::device() else { return };
    for (name, bright) in [("bright", true), ("shadow", false)] {
        let (rows, expected) = sample(&device, bright, PixelFormat::Mono12);
        judge(name, &rows, &expected);
    }
}

/// Dark current over 50 ms at 16 K above its data sheet: 4 · 40 e⁻/s · 0.05 s = 8 e⁻ in every
/// pixel, lit or not, with Poisson noise of their own; frames without the table keep their bytes.
#[test]
fn dark_current_raises_levels_and_noise_by_its_electrons() {
    let mut settings = SetupSettings { departures: SetupDeviations::none(), ..Default::default() };
    settings.camera.rows = 2048;
    settings.camera.exposure_us = 50_000.0;
    settings.camera.frame_period_ms = 100.0;
    settings.light.shadow_counts = settings.sensor.black_level_counts;
    settings.sensor.read_noise_e = 3.0;
    settings.sensor.electrons_per_count = 0.5;
    let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
    let shadow = |settings: &SetupSettings| {
        let setup = OpticalSetup::resolve(settings, 0).unwrap();
        let scene = Scene::new(&setup, Shaft::cylinder(30.0)).unwrap();
        let columns = setup.columns();
        let roi = Some(Roi { row: 960, column: 0, rows: 64, columns: columns as u32 });
        let format = Some(PixelFormat::F32);
        let request = FrameRequest { noise: true, seed: 77, roi, format, ..Default::default() };
        let frame = renderer.render(&scene, &request, None).unwrap();
        moments(&counts(&frame).chunks_exact(columns).map(<[f64]>::to_vec).collect::<Vec<_>>())
    };
    let without = shadow(&settings);
    settings.sensor.dark_current = Some(DarkCurrent {
        electrons_per_s: 40.0,
        measured_at_c: 25.0,
        doubling_k: 8.0,
        temperature_c: 41.0,
        ..DarkCurrent::default()
    });
    let with = shadow(&settings);
    // 64 rows of some thousand pixels: the mean of σ = 8.2 counts is known to 0.03, the variance to
    // 0.5 %, 0.1 e⁻².
    assert!((with.mean - without.mean - 16.0).abs() < 0.15, "{} {}", with.mean, without.mean);
    let gained_e2 = 0.25 * (with.variance - without.variance);
    assert!((gained_e2 - 8.0).abs() < 0.4, "{gained_e2}");
}
