//! Of a response that bends before it ends.

use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;

use super::*;
use crate::gauge::edge::image::scan_windows::Side;

#[test]
fn a_clipped_deviate_keeps_its_textbook_variance() {
    // Half of it clipped: d is half-normal with probability 1/2, E[d] = φ(0), E[d²] = 1/2.
    let half = 0.5 - 1.0 / (2.0 * std::f64::consts::PI);
    assert!((clipped_variance(0.5) - half).abs() < 1e-9);
    assert!((clipped_variance(0.0) - 1.0).abs() < 1e-6 && clipped_variance(1.0) < 1e-6);
}

/// Knees of video cameras begin at 80 % of full scale and above.
#[test]
fn grey_values_well_below_a_knee_are_taken_as_they_stand() {
    assert_eq!(trusted([20.0, 220.0], 1.0), 150.0);
    assert_eq!(trusted([20.0, 220.0], 16.0), 160.0);
}

/// Whether light without any scatter beside a flank of so much noise, counts, is found to be
/// compressed: levels of 20 and 200 counts, the noise in the dark as a share of the contrast, the
/// step of the grey scale.
fn compressed(flank: f64, in_dark: f64, step: f64) -> bool {
    let (columns, width) = (4096, 17);
    let mut rng = Pcg64::seed_from_u64(3);
    let noise = Normal::new(0.0, flank).unwrap();
    let mut windows = Windows::new(Side::Bottom);
    (windows.width, windows.flat) = (width, 4);
    for _ in 0..columns {
        let level = |k: usize| 20.0 + 180.0 * (k as f64 - 4.0).clamp(0.0, 8.0) / 8.0;
        let value = |k: usize| level(k) + if (5..12).contains(&k) { noise.sample(&mut rng) } else { 0.0 };
        windows.pixels.extend((0..width).map(value).map(|value| value as f32));
        windows.centre.push(Ok(50));
    }
    let noise = [180.0 * in_dark, f64::NAN];
    let elsewhere = Elsewhere { noise, levels: [20.0, 200.0], step, turned: false };
    find(&windows, None, &elsewhere, &mut Vec::new()).is_some()
}

/// Between a thousandth of the contrast, where the part's own drift is all that scatters, and a
/// tenth, where the flank is found among the noise.
#[test]
fn light_is_compressed_beside_a_noise_that_can_be_told() {
    assert!(!compressed(1.0, 0.7e-3, 0.0));
    assert!(compressed(1.0, 1.4e-3, 0.0) && compressed(1.0, 0.07, 0.0));
    assert!(!compressed(1.0, 0.14, 0.0));
}

/// In whole counts a variance of 0.18 counts² is expected of light that rounding may hide, one of
/// 0.36 of light that scatters over several counts.
#[test]
fn rounding_is_no_compression() {
    let flank = |expected: f64| f64::sqrt(expected + 1.0 / 12.0);
    assert!(!compressed(flank(0.18), 0.01, 1.0));
    assert!(compressed(flank(0.36), 0.01, 1.0));
}
