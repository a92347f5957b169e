//! Photon transfer on frames computed here, of given gain, read noise, non-uniformity and
//! linearity.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use rand::{RngExt, SeedableRng};
use rand_distr::{Normal, Poisson};
use rand_pcg::Pcg64;
use shadowgauge::frame::{Buffer, Frame, FrameMeta, PixelFormat};
use shadowgauge::gauge::photon_transfer::{FramePair, PhotonTransfer, PhotonTransferError, photon_transfer};

const SIDE: usize = 400;

/// A sensor with fixed patterns.
struct Sensor {
    gain: f64,
    read: f64,
    black: f64,
    bend: f64,
    format: PixelFormat,
    prnu: Vec<f64>,
    dsnu: Vec<f64>,
}

impl Sensor {
    /// `patterns`: standard deviations of PRNU and DSNU (electrons).
    fn new(random: &mut Pcg64, gain: f64, read: f64, patterns: [f64; 2], format: PixelFormat) -> Self {
        let normal = Normal::new(0.0, 1.0).unwrap();
        let mut pattern = |sd: f64| {
            let raw: Vec<f64> = (0..SIDE * SIDE).map(|_| random.sample(normal)).collect();
            // Exactly the stated standard deviation, so that 1 % is the gauge's own error.
            let mean = raw.iter().sum::<f64>() / raw.len() as f64;
            let own = (raw.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / raw.len() as f64).sqrt();
            raw.iter().map(|v| sd * (v - mean) / own).collect::<Vec<f64>>()
        };
        Self {
            gain,
            read,
            black: 20.0,
            bend: 0.0,
            format,
            prnu: pattern(patterns[0]),
            dsnu: pattern(patterns[1]),
        }
    }

    /// A frame at a mean of `electrons`, lit with a slow fall-off of 10 % to a side.
    fn frame(&self, random: &mut Pcg64, electrons: f64) -> Frame {
        let normal = Normal::new(0.0, self.read).unwrap();
        let counts = (0..SIDE * SIDE).map(|i| {
            let light = 1.0 + 0.1 * ((i % SIDE) as f64 / (SIDE - 1) as f64 - 0.5);
            let mean = electrons * (1.0 - self.bend * electrons) * light * (1.0 + self.prnu[i]);
            let photo = if mean > 0.0 { random.sample(Poisson::new(mean).unwrap()) } else { 0.0 };
            let value = self.black + self.gain * (photo + self.dsnu[i] + random.sample(normal));
            let full = self.format.full_scale().map_or(f64::INFINITY, f64::from);
            value.clamp(0.0, full)
        });
        let buffer = match self.format {
            PixelFormat::F32 => Buffer::F32(counts.map(|v| v as f32).collect()),
            PixelFormat::Mono8 => Buffer::U8(counts.map(|v| v.round() as u8).collect()),
            _ => Buffer::U16(counts.map(|v| v.round() as u16).collect()),
        };
        Frame::new(buffer, self.format, SIDE, SIDE, FrameMeta::default()).unwrap()
    }

    fn measure(&self, random: &mut Pcg64, electrons: &[f64]) -> Result<PhotonTransfer, PhotonTransferError> {
        let mut pair = |e: f64| (e, self.frame(random, e), self.frame(random, e));
        let flats: Vec<_> = electrons.iter().map(|e| pair(*e)).collect();
        let darks: Vec<_> = (0..4).map(|_| pair(0.0)).collect();
        fn views(pairs: &[(f64, Frame, Frame)]) -> Vec<FramePair<'_>> {
            pairs
                .iter()
                .map(|(exposure, a, b)| FramePair { exposure: *exposure, first: a.view(), second: b.view() })
                .collect()
        }
        photon_transfer(&views(&flats), &views(&darks))
    }
}

fn within(name: &str, found: f64, truth: f64, relative: f64) {
    let error = found / truth - 1.0;
    println!("{name}: {found:.6} for {truth}, {:+.2} %", 100.0 * error);
    assert!(error.abs() < relative, "{name}: {found} for {truth}");
}

#[test]
fn a_12_bit_sensor_is_found_within_one_percent() {
    let mut random = Pcg64::seed_from_u64(11);
    let sensor = Sensor::new(&mut random, 0.25, 8.0, [0.01, 6.0], PixelFormat::Mono12);
    let exposures: Vec<f64> = (1..=12).map(|k| 1200.0 * f64::from(k)).collect();
    let found = sensor.measure(&mut random, &exposures).unwrap();
    within("gain", found.gain_counts_per_electron, 0.25, 0.01);
    within("read noise", found.read_noise_electrons, 8.0, 0.01);
    within("DSNU", found.dsnu_electrons, 6.0, 0.01);
    within("PRNU", found.prnu, 0.01, 0.01);
    within("black", found.black_counts, 20.0, 0.01);
    within("responsivity", found.responsivity, 0.25, 0.01);
    assert!(found.linearity_error < 1e-3, "{}", found.linearity_error);
    let pull = (found.gain_counts_per_electron / 0.25 - 1.0) / found.u_gain_relative;
    assert!(pull.abs() < 3.5 && found.u_gain_relative < 0.01, "{pull} {}", found.u_gain_relative);
}

#[test]
fn a_coarse_8_bit_sensor_and_unquantised_counts_are_found_within_one_percent() {
    let mut random = Pcg64::seed_from_u64(12);
    let exposures: Vec<f64> = (1..=10).map(|k| 900.0 * f64::from(k)).collect();
    for (gain, format) in [(0.02, PixelFormat::Mono8), (0.3, PixelFormat::F32)] {
        let mut sensor = Sensor::new(&mut random, gain, 40.0, [0.02, 20.0], format);
        // Five standard deviations of the dark above zero.
        sensor.black = 4.0 + 250.0 * gain;
        let found = sensor.measure(&mut random, &exposures).unwrap();
        within("gain", found.gain_counts_per_electron, gain, 0.01);
        within("read noise", found.read_noise_electrons, 40.0, 0.01);
        within("PRNU", found.prnu, 0.02, 0.01);
    }
}

#[test]
fn a_bent_response_shows_in_the_linearity_error() {
    let mut random = Pcg64::seed_from_u64(13);
    let mut sensor = Sensor::new(&mut random, 0.25, 8.0, [0.001, 1.0], PixelFormat::Mono16);
    sensor.bend = 5e-6;
    let exposures: Vec<f64> = (1..=8).map(|k| 1500.0 * f64::from(k)).collect();
    let found = sensor.measure(&mut random, &exposures).unwrap();
    // Independent: the same line by brute force over slopes and offsets of the exact response.
    let exact: Vec<(f64, f64)> = exposures.iter().map(|e| (*e, 0.25 * e * (1.0 - 5e-6 * e))).collect();
    let top = exact[7].1;
    let kept: Vec<_> = exact.iter().filter(|(_, y)| *y >= 0.05 * top && *y <= 0.95 * top).collect();
    let mut best = (f64::INFINITY, 0.0);
    for s in 0..400 {
        for o in -200..200 {
            let (slope, offset) = (0.2 + 0.00025 * f64::from(s), 0.5 * f64::from(o));
            let d: Vec<f64> = kept.iter().map(|(x, y)| (y - offset - slope * x) / y).collect();
            let sum = d.iter().map(|v| v * v).sum::<f64>();
            if sum < best.0 {
                best = (sum, d.iter().map(|v| v.abs()).sum::<f64>() / d.len() as f64);
            }
        }
    }
    within("linearity error", found.linearity_error, best.1, 0.15);
}

/// Three flats of one exposure and a brighter one used to yield a quarter of the true responsivity,
/// from rounding.
#[test]
fn exposures_that_do_not_differ_are_refused() {
    let mut random = Pcg64::seed_from_u64(15);
    let sensor = Sensor::new(&mut random, 0.25, 8.0, [0.005, 2.0], PixelFormat::Mono12);
    for exposures in [
        &[4000.0, 4000.0, 4000.0, 10_000.0][..],
        &[4000.0, 4010.0, 4020.0, 10_000.0],
        // Two of them lie below 5 % of saturation: only one remains for the line.
        &[100.0, 200.0, 4000.0, 10_000.0],
    ] {
        let refused = sensor.measure(&mut random, exposures);
        assert!(matches!(refused, Err(PhotonTransferError::SameExposures { .. })), "{refused:?}");
    }
    let found = sensor.measure(&mut random, &[2000.0, 4000.0, 4000.0, 6000.0, 10_000.0]).unwrap();
    within("responsivity", found.responsivity, 0.25, 0.01);
}

#[test]
fn clipped_exposures_are_left_out_and_poor_series_refused() {
    let mut random = Pcg64::seed_from_u64(14);
    let sensor = Sensor::new(&mut random, 0.25, 8.0, [0.005, 2.0], PixelFormat::Mono12);
    let exposures: Vec<f64> = (1..=12).map(|k| 2000.0 * f64::from(k)).collect();
    let found = sensor.measure(&mut random, &exposures).unwrap();
    within("gain", found.gain_counts_per_electron, 0.25, 0.01);
    assert!(found.curve.iter().any(|p| !p.used && p.clipped > 0.5));
    let few = sensor.measure(&mut random, &[1000.0, 30_000.0, 40_000.0]);
    assert!(matches!(few, Err(PhotonTransferError::TooFewExposures { .. })), "{few:?}");
    assert_eq!(photon_transfer(&[], &[]), Err(PhotonTransferError::NoDark));
    // A black level of one standard deviation clips the dark noise: no read noise is reported.
    let mut cut = Sensor::new(&mut random, 0.25, 8.0, [0.005, 2.0], PixelFormat::Mono12);
    cut.black = 2.0;
    let refused = cut.measure(&mut random, &exposures);
    assert!(matches!(refused, Err(PhotonTransferError::DarkClipped { .. })), "{refused:?}");
}
