//! A response that bends before it ends (a soft knee, the flat top of a gamma curve): found by its
//! noise.
//!
//! Photon noise grows with the light, so that a linear sensor's light scatters at least as much as
//! its flanks and its dark. Light that scatters far less has been compressed. Where the bend begins
//! cannot be seen from the flat pixels: grey values above [`SoftKneeLimits::trusted`] of the
//! contrast are then taken as "at least this much", as clipped ones are. Light that is clipped
//! altogether shows no noise: there the shape of the flank determines it (`censored_fit`).

use super::grey_ends::{Elsewhere, GreyEndLimits, flank_noise, light_scatter};
use crate::gauge::edge::image::scan_windows::Windows;
use crate::gauge::limit::limits;
use crate::numerics::distributions::{inverse_tail, phi_cdf, phi_pdf};

limits! {
    /// What separates a response that bends from a linear sensor's.
    SoftKneeLimits = "soft_knee";
    /// Fraction of the expected variance of the light below which it is compressed: a slope of √0.3
    /// = .55. A linear sensor's is 1 or more, known to some per cent; gentler bends move an edge by
    /// less than the model uncertainty then added.
    compressed: f64 = 0.3;
    /// Least variance expected of the light, squared steps of the grey scale: three times that of
    /// rounding, 1/12. Where the grey scale is finer, the scatter that counts as noise takes its
    /// place ([`GreyEndLimits`]).
    least_expected: f64 = 0.25;
    /// Noise in the dark, as a fraction of the contrast, below which there is no scatter that could
    /// be compressed: the remainder is the part's own drift through the pixels.
    least_noise: f64 = 1e-3;
    /// Noise in the dark, as a fraction of the contrast, above which the flank, found among it, is
    /// a biased sample of it. Tuned: see study limits.
    most_noise: f64 = 0.1;
    /// Share of the contrast up to which grey values are taken as they stand: knees of video
    /// cameras begin at 80 to 95 % of full scale, the lowest a fifth above it.
    trusted: f64 = 0.65;
}

/// The grey value from which on the light may be compressed, and the distance of two grey values;
/// `None` where its noise is a linear sensor's, and where what is called light is the dark ground
/// of a lit part. `hard` is the end at which the light was found to be clipped, if it was;
/// `elsewhere` holds levels and noise, `squares` is scratch.
pub(crate) fn find(
    windows: &Windows,
    hard: Option<f32>,
    elsewhere: &Elsewhere,
    squares: &mut Vec<f32>,
) -> Option<(f32, f64)> {
    let limits = SoftKneeLimits::get();
    let step = elsewhere.step;
    let rounding = step * step / 12.0;
    let noise = elsewhere.noise[0] / (elsewhere.levels[1] - elsewhere.levels[0]);
    if elsewhere.turned || noise < limits.least_noise || noise > limits.most_noise {
        return None;
    }
    let (seen, at_end) = light_scatter(windows, (hard, step), squares)?;
    let seen = (seen - rounding).max(0.0);
    if hard.is_none() && !(seen + rounding < elsewhere.noise[0].powi(2)) {
        return None;
    }
    let flank = (flank_noise(windows, elsewhere, squares)?.powi(2) - rounding).max(0.0);
    let expected = flank * clipped_variance(at_end);
    // Light that is clipped almost everywhere shows no scatter that could be compressed.
    let of_contrast = GreyEndLimits::get().least_noise_contrast * (elsewhere.levels[1] - elsewhere.levels[0]);
    let least = (limits.least_expected * step * step).max(of_contrast * of_contrast);
    let compressed = expected > least && seen < limits.compressed * expected;
    compressed.then(|| (trusted(elsewhere.levels, step) as f32, step))
}

/// Grey value, a whole number of steps, up to which a response that may bend is taken as it stands;
/// `levels` of dark and light, counts.
pub(crate) fn trusted([dark, light]: [f64; 2], step: f64) -> f64 {
    let end = dark + SoftKneeLimits::get().trusted * (light - dark);
    if step > 0.0 { (end / step).ceil() * step } else { end }
}

/// Variance of a normal deviate of variance 1 whose share `at_end` is clipped at an upper end: with
/// z the end's distance above the mean and d what a deviate lies below it, `E[d] = zΦ + φ` and
/// `E[d²] = (z² + 1)Φ + zφ`.
fn clipped_variance(at_end: f64) -> f64 {
    let z = inverse_tail(at_end.clamp(1e-9, 1.0 - 1e-9));
    let (cdf, pdf) = (phi_cdf(z), phi_pdf(z));
    let mean = z * cdf + pdf;
    (z * z + 1.0) * cdf + z * pdf - mean * mean
}

#[cfg(test)]
mod tests;
