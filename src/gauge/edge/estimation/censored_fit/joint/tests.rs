//! Of the noise that a clipped shadow shows.

use super::super::score::Noise;
use super::*;
use crate::gauge::edge::estimation::censored::Ends;
use crate::gauge::edge::model::edge_spread::EdgeSpreadFunction;

/// The noise of a shadow clipped in part over the one assumed, from so many pixels of which each is
/// expected to show 0.4 of a square, and shows 0.6.
fn excess_of(pixels: f64) -> Option<f64> {
    let noise = Noise { level: 0.0, variance: 4.0, gain: 0.0, floor: 0.01, unexplained: 0.0 };
    let ends = Ends { low: 0.0, high: f64::INFINITY, step: 1.0 };
    let joint = Joint {
        likelihood: Likelihood::new(&EdgeSpreadFunction::Gaussian, ends, noise),
        dark: Level::free(&[1.0; 8], (0, 7), 2),
        light: Level::known(&[200.0; 8], 0.1),
        sigma: 1.0,
        sigma_prior: None,
        columns: vec![FittedColumn { index: 4, place: 0.0 }],
    };
    let sums = Sums {
        normal: DMatrix::zeros(1, 1),
        right: DVector::zeros(1),
        chi2: 0.0,
        informative: 0.0,
        flank: [0.0; 2],
        on_flank: 0.0,
        in_dark: [0.6 * pixels, 0.4 * pixels, pixels],
        by_noise: DVector::zeros(1),
    };
    joint.own_noise(&sums)
}

/// A sum of squares of 36 is known to √(2/36), a quarter: no better than the straight line through
/// light and flank. One of 70 is known to a sixth, its root to a twelfth.
#[test]
fn a_clipped_shadow_shows_its_noise_where_enough_of_it_is_seen() {
    assert_eq!(excess_of(90.0), None);
    assert!(excess_of(175.0).is_some_and(|ratio| (ratio - 1.5).abs() < 1e-12));
}
