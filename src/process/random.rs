//! Independent random streams of one seed, and the smoothing kernel for correlated noise.

use rand_pcg::Pcg64;

/// Half width of the smoothing kernel in standard deviations: 1e-3 of the peak.
const KERNEL_REACH: f64 = 3.7;

/// The purpose of a stream of random numbers, which separates the streams of one seed.
#[derive(Clone, Copy, Debug)]
pub(super) enum Stream {
    /// Heights of the surface.
    Texture = 1,
    /// Small lobes.
    Lobes = 2,
    /// Form of the blank.
    StockForm = 3,
    /// Force of the blank's material.
    Force = 4,
    /// Position of the tool in a pass.
    Repeatability = 5,
}

/// The generator of a (seed, purpose, pass).
pub(super) fn generator(seed: u64, stream: Stream, pass: u32) -> Pcg64 {
    Pcg64::new(u128::from(seed), (stream as u128) << 32 | u128::from(pass))
}

/// Gaussian weights whose squares add up to one, so that white noise keeps its variance. Smoothed
/// noise has the autocorrelation exp(-τ²/4s²), which is 1/e at τ = 2s.
pub(super) fn smoothing_kernel(sd_nodes: f64) -> Vec<f64> {
    let reach = (KERNEL_REACH * sd_nodes).ceil() as i32;
    let raw: Vec<f64> = (-reach..=reach).map(|i| (-0.5 * (f64::from(i) / sd_nodes).powi(2)).exp()).collect();
    let norm = raw.iter().map(|w| w * w).sum::<f64>().sqrt();
    raw.iter().map(|w| w / norm).collect()
}
