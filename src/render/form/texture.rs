//! Roughness and waviness by seed.
//!
//! The texture is a Gaussian random field with a Gaussian autocorrelation exp(-(Δz/l_z)² -
//! (Δθ/l_θ)²), drawn on a grid of four nodes per correlation length and bilinear between them;
//! white noise is convolved with exp(-2(Δ/l)²) in each direction (the kernel whose self-convolution
//! is that autocorrelation) and scaled to the rms. Any other spectrum S(f) along z is applied by
//! Fourier transform: white noise times √S, periodic over twice the length.

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use crate::render::error::{RenderError, within};
use crate::shaft::{SurfaceTexture, TextureForm, TextureSpectrum};

/// Grid nodes per correlation length: a bilinear grid of four preserves 97 % of the field's
/// variance between the nodes.
const NODES_PER_LENGTH: f64 = 4.0;

/// Grid nodes per correlation length of an exponential autocorrelation, whose density decreases
/// only as f^-2, and per shortest wavelength.
const EXPONENTIAL_NODES: f64 = 10.0;
const NODES_PER_WAVE: f64 = 4.0;

/// Half width of the smoothing kernel in correlation lengths; exp(-2·1.75²) = 0.002.
const KERNEL_REACH: f64 = 1.75;

/// Most nodes of a texture: 64 MiB of f32.
const MOST_NODES: f64 = 1.6e7;

/// Stream of the generator that textures are drawn from.
const TEXTURE_STREAM: u64 = 0x0074_6578_7475_7265;

/// Draws the surface by seed.
pub(super) fn draw_texture(
    form: &TextureForm,
    length_mm: f64,
    seed: u64,
) -> Result<SurfaceTexture, RenderError> {
    within("shaft.texture.rms_um", form.rms_um, 0.0, 1000.0)?;
    within("shaft.texture.correlation_z_mm", form.correlation_z_mm, 1e-4, 1e5)?;
    within("shaft.texture.correlation_theta_deg", form.correlation_theta_deg, 0.01, 180.0)?;
    let columns = (360.0 * NODES_PER_LENGTH / form.correlation_theta_deg).ceil();
    check_spectrum(&form.spectrum)?;
    let step_mm = step_mm(form);
    let rows = (length_mm / step_mm).ceil() + 1.0;
    if rows * columns > MOST_NODES {
        return Err(RenderError::setting(
            "shaft.texture.correlation_z_mm",
            &form.correlation_z_mm,
            format!(
                "a grid of {rows} x {columns} nodes is too large ({MOST_NODES:.0} at most): take longer correlation lengths"
            ),
        ));
    }
    let (rows, columns) = (rows as usize, columns as usize);
    if form.spectrum != TextureSpectrum::Gaussian {
        return Ok(by_spectrum(form, rows, columns, seed));
    }
    let mut random = Pcg64::seed_from_u64(seed ^ TEXTURE_STREAM);
    let along = kernel(NODES_PER_LENGTH);
    let reach = along.len() / 2;
    let white: Vec<f64> =
        (0..(rows + 2 * reach) * columns).map(|_| StandardNormal.sample(&mut random)).collect();
    let around = kernel(columns as f64 * form.correlation_theta_deg / 360.0);
    let smooth = smooth_turns(&white, columns, &around);
    let height_mm = smooth_rows(&smooth, rows, columns, &along)
        .into_iter()
        .map(|h| (h * form.rms_um * 1e-3) as f32)
        .collect();
    Ok(SurfaceTexture { z0_mm: 0.0, step_mm, nodes_theta: columns, height_mm })
}

/// Weights exp(-2(i/length)²) with a sum of squares of one, so that white noise keeps its variance.
fn kernel(length: f64) -> Vec<f64> {
    let reach = (KERNEL_REACH * length).ceil() as i64;
    let raw: Vec<f64> = (-reach..=reach).map(|i| (-2.0 * (i as f64 / length).powi(2)).exp()).collect();
    let norm = raw.iter().map(|w| w * w).sum::<f64>().sqrt();
    raw.iter().map(|w| w / norm).collect()
}

fn smooth_turns(white: &[f64], columns: usize, kernel: &[f64]) -> Vec<f64> {
    let reach = kernel.len() / 2;
    white
        .chunks_exact(columns)
        .flat_map(|row| {
            (0..columns).map(move |j| {
                kernel
                    .iter()
                    .enumerate()
                    .map(|(i, w)| w * row[(j + columns * (1 + reach / columns) + i - reach) % columns])
                    .sum()
            })
        })
        .collect()
}

fn smooth_rows(field: &[f64], rows: usize, columns: usize, kernel: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; rows * columns];
    for (row, target) in out.chunks_exact_mut(columns).enumerate() {
        for (i, w) in kernel.iter().enumerate() {
            let source = &field[(row + i) * columns..(row + i + 1) * columns];
            for (t, s) in target.iter_mut().zip(source) {
                *t += w * s;
            }
        }
    }
    out
}

/// Distance of rows that resolves the finest wave of the spectrum.
fn step_mm(form: &TextureForm) -> f64 {
    match &form.spectrum {
        TextureSpectrum::Gaussian => form.correlation_z_mm / NODES_PER_LENGTH,
        TextureSpectrum::Exponential => form.correlation_z_mm / EXPONENTIAL_NODES,
        TextureSpectrum::PowerLaw { shortest_mm, .. } => shortest_mm / NODES_PER_WAVE,
        TextureSpectrum::Points { per_mm, .. } => {
            1.0 / (NODES_PER_WAVE * per_mm.last().copied().unwrap_or(1.0))
        }
    }
}

/// Density of the spectrum at a frequency, 1/mm, any unit.
fn density(form: &TextureForm, per_mm: f64) -> f64 {
    match &form.spectrum {
        TextureSpectrum::Gaussian => 0.0,
        TextureSpectrum::Exponential => {
            1.0 / (1.0 + (std::f64::consts::TAU * form.correlation_z_mm * per_mm).powi(2))
        }
        TextureSpectrum::PowerLaw { exponent, longest_mm, shortest_mm } => {
            if per_mm > 1.0 / shortest_mm {
                0.0
            } else {
                per_mm.max(1.0 / longest_mm).powf(-exponent)
            }
        }
        TextureSpectrum::Points { per_mm: at, density } => {
            let after = at.partition_point(|f| *f <= per_mm);
            match (after.checked_sub(1), at.get(after)) {
                (Some(i), Some(next)) => {
                    density[i] + (density[after] - density[i]) * (per_mm - at[i]) / (next - at[i])
                }
                (Some(i), None) if at[i] == per_mm => density[i],
                _ => 0.0,
            }
        }
    }
}

fn check_spectrum(spectrum: &TextureSpectrum) -> Result<(), RenderError> {
    match spectrum {
        TextureSpectrum::Gaussian | TextureSpectrum::Exponential => Ok(()),
        TextureSpectrum::PowerLaw { exponent, longest_mm, shortest_mm } => {
            within("shaft.texture.spectrum.power_law.exponent", *exponent, 0.0, 10.0)?;
            within("shaft.texture.spectrum.power_law.longest_mm", *longest_mm, 1e-4, 1e5)?;
            within("shaft.texture.spectrum.power_law.shortest_mm", *shortest_mm, 1e-4, *longest_mm)
        }
        TextureSpectrum::Points { per_mm, density } => {
            let rising = per_mm.windows(2).all(|p| p[0] < p[1]) && per_mm.first().is_some_and(|f| *f >= 0.0);
            let fits = per_mm.len() == density.len() && per_mm.len() >= 2;
            let level =
                density.iter().all(|d| d.is_finite() && *d >= 0.0) && density.iter().any(|d| *d > 0.0);
            if rising && fits && level && per_mm.iter().all(|f| f.is_finite()) {
                return Ok(());
            }
            let right = "needs rising frequencies from 0 on and as many densities, none negative, not all 0";
            let found = format!("{} frequencies, {} densities", per_mm.len(), density.len());
            Err(RenderError::setting("shaft.texture.spectrum.points.per_mm", &found, right))
        }
    }
}

/// White noise, correlated around the circumference, with the spectrum along z.
fn by_spectrum(form: &TextureForm, rows: usize, columns: usize, seed: u64) -> SurfaceTexture {
    let step_mm = step_mm(form);
    // Twice the length, so that the two ends of the periodic part are not neighbours.
    let length = 2 * rows;
    let mut random = Pcg64::seed_from_u64(seed ^ TEXTURE_STREAM);
    let white: Vec<f64> = (0..length * columns).map(|_| StandardNormal.sample(&mut random)).collect();
    let around = kernel(columns as f64 * form.correlation_theta_deg / 360.0);
    let smooth = smooth_turns(&white, columns, &around);
    let mut gain: Vec<f64> = (0..length)
        .map(|k| k.min(length - k) as f64 / (length as f64 * step_mm))
        .map(|f| if f == 0.0 { 0.0 } else { density(form, f).sqrt() })
        .collect();
    let power = gain.iter().map(|g| g * g).sum::<f64>() / length as f64;
    // The inverse transform is not normalised: it has the length as a factor.
    gain.iter_mut()
        .for_each(|g| *g *= form.rms_um * 1e-3 / power.sqrt().max(f64::MIN_POSITIVE) / length as f64);
    let mut planner = FftPlanner::new();
    let (forward, back) = (planner.plan_fft_forward(length), planner.plan_fft_inverse(length));
    let mut height_mm = vec![0.0f32; rows * columns];
    let mut line = vec![Complex::new(0.0, 0.0); length];
    for j in 0..columns {
        line.iter_mut().enumerate().for_each(|(i, c)| *c = Complex::new(smooth[i * columns + j], 0.0));
        forward.process(&mut line);
        line.iter_mut().zip(&gain).for_each(|(c, g)| *c *= *g);
        back.process(&mut line);
        (0..rows).for_each(|i| height_mm[i * columns + j] = line[i].re as f32);
    }
    SurfaceTexture { z0_mm: 0.0, step_mm, nodes_theta: columns, height_mm }
}
