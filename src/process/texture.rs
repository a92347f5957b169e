//! The surface that a pass leaves: correlated heights and small lobes, from (seed, pass) alone.
//!
//! White Gaussian noise on a grid of z and θ is smoothed by a separable Gaussian kernel of standard
//! deviation half the correlation length (periodic in θ) and scaled to the configured rms. The
//! autocorrelation of noise smoothed by a Gaussian of standard deviation s is exp(-τ²/4s²), which
//! is 1/e at τ = 2s.

use rand_distr::{Distribution, StandardNormal};

use super::random::{Stream, generator, smoothing_kernel};
use super::settings::TextureSettings;
use crate::shaft::{Lobe, SurfaceTexture};

/// Grid nodes in a correlation length: bilinear interpolation needs at least two.
const NODES_PER_CORRELATION: f64 = 2.5;
/// Nodes in a feed mark, where feed marks are drawn.
const NODES_PER_FEED: f64 = 8.0;

/// Heights over a shaft of `length_mm`; `None` for a smooth surface.
pub(super) fn surface(
    settings: &TextureSettings,
    length_mm: f64,
    seed: u64,
    pass: u32,
) -> Option<SurfaceTexture> {
    if settings.rms_um == 0.0 {
        return None;
    }
    let rows = (length_mm * NODES_PER_CORRELATION / settings.correlation_z_mm).ceil() as usize + 1;
    let step_mm = length_mm / (rows - 1) as f64;
    let nodes_theta = (360.0 * NODES_PER_CORRELATION / settings.correlation_deg).ceil() as usize;
    let kernel_z = kernel_f32(0.5 * settings.correlation_z_mm / step_mm);
    let kernel_theta = kernel_f32(0.5 * settings.correlation_deg * nodes_theta as f64 / 360.0);
    let margin = kernel_z.len() / 2;
    let mut random = generator(seed, Stream::Texture, pass);
    let noise: Vec<f32> =
        (0..(rows + 2 * margin) * nodes_theta).map(|_| StandardNormal.sample(&mut random)).collect();
    let around: Vec<f32> =
        noise.chunks_exact(nodes_theta).flat_map(|row| smooth_ring(row, &kernel_theta)).collect();
    let scale = (settings.rms_um * 1e-3) as f32;
    let height_mm =
        (0..rows).flat_map(|row| smooth_rows(&around, row, nodes_theta, &kernel_z, scale)).collect();
    Some(SurfaceTexture { z0_mm: 0.0, step_mm, nodes_theta, height_mm })
}

fn kernel_f32(sd_nodes: f64) -> Vec<f32> {
    smoothing_kernel(sd_nodes).iter().map(|w| *w as f32).collect()
}

/// The same surface with the helix that a tool of nose radius r leaves at a feed f: heights s²/2r,
/// s the distance along z from the middle of the mark, f²/8r at the crests. The valleys lie at the
/// radius of the cut.
pub(super) fn with_feed_marks(
    surface: Option<&SurfaceTexture>,
    length_mm: f64,
    feed_mm: f64,
    nose_radius_mm: f64,
) -> SurfaceTexture {
    let nodes_theta = surface.map_or(120, |s| s.nodes_theta);
    let rows = (length_mm * NODES_PER_FEED / feed_mm).ceil() as usize + 1;
    let step_mm = length_mm / (rows - 1) as f64;
    let mark = |z_mm: f64, j: usize| {
        let turns = z_mm / feed_mm + j as f64 / nodes_theta as f64;
        let s = feed_mm * (turns - turns.round());
        (s * s / (2.0 * nose_radius_mm)) as f32
    };
    let rough = |z_mm: f64, j: usize| surface.map_or(0.0, |s| along(s, z_mm, j));
    let height = |z_mm: f64| (0..nodes_theta).map(move |j| mark(z_mm, j) + rough(z_mm, j));
    let height_mm = (0..rows).flat_map(|row| height(row as f64 * step_mm)).collect();
    SurfaceTexture { z0_mm: 0.0, step_mm, nodes_theta, height_mm }
}

/// Height between two rows of nodes.
fn along(surface: &SurfaceTexture, z_mm: f64, j: usize) -> f32 {
    let rows = surface.height_mm.len() / surface.nodes_theta;
    let position = (z_mm - surface.z0_mm) / surface.step_mm;
    let row = (position as usize).min(rows.saturating_sub(2));
    let at = |row: usize| surface.height_mm.get(row * surface.nodes_theta + j).copied().unwrap_or(0.0);
    let share = (position - row as f64) as f32;
    at(row) + share * (at(row + 1) - at(row))
}

/// One row, smoothed around the circumference.
fn smooth_ring<'a>(row: &'a [f32], kernel: &'a [f32]) -> impl Iterator<Item = f32> + 'a {
    let (n, reach) = (row.len(), kernel.len() / 2);
    (0..n).map(move |j| {
        let start = j + n * (1 + reach / n) - reach;
        kernel.iter().enumerate().map(|(i, w)| w * row[(start + i) % n]).sum()
    })
}

/// One row, smoothed along z; `rows` includes margins as wide as the kernel's reach before and
/// after.
fn smooth_rows<'a>(
    rows: &'a [f32],
    row: usize,
    n: usize,
    kernel: &'a [f32],
    scale: f32,
) -> impl Iterator<Item = f32> + 'a {
    (0..n).map(move |j| {
        scale * kernel.iter().enumerate().map(|(i, w)| w * rows[(row + i) * n + j]).sum::<f32>()
    })
}

/// Lobes of orders 2 to 5 with normally distributed amplitudes and uniform phases.
pub(super) fn small_lobes(settings: &TextureSettings, seed: u64, pass: u32) -> Vec<Lobe> {
    if settings.lobe_um == 0.0 {
        return Vec::new();
    }
    let mut random = generator(seed, Stream::Lobes, pass);
    (2..=5)
        .map(|order_upr| {
            let (re, im): (f64, f64) =
                (StandardNormal.sample(&mut random), StandardNormal.sample(&mut random));
            // Re and im give a Rayleigh amplitude with mean square 2; the phase is uniform.
            let amplitude_mm = settings.lobe_um * 1e-3 * re.hypot(im) / std::f64::consts::SQRT_2;
            Lobe { order_upr, amplitude_mm, phase_deg: im.atan2(re).to_degrees() / f64::from(order_upr) }
        })
        .collect()
}
