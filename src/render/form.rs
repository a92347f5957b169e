//! Form errors as a user writes them, laid over the diameters that a pass leaves behind.
//!
//! The texture is a Gaussian random field with a Gaussian autocorrelation exp(-(Δz/l_z)² - (Δθ/l_θ)²), drawn on a
//! grid of four nodes a correlation length and bilinear between them; white noise is convolved with
//! exp(-2(Δ/l)²) in each direction (the kernel whose self-convolution is that autocorrelation) and scaled to the rms.

use std::f64::consts::PI;

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use super::error::{RenderError, within};
use crate::shaft::{AxisKnot, Bow, Deflection, ProfileKnot, Shaft, ShaftForm, SurfaceTexture, TextureForm};

/// Grid nodes a correlation length: a bilinear grid of four keeps 97 % of the field's variance between the nodes.
const NODES_PER_LENGTH: f64 = 4.0;

/// Half width of the smoothing kernel in correlation lengths; exp(-2·1.75²) = .002.
const KERNEL_REACH: f64 = 1.75;

/// Most nodes of a texture: 64 MiB of f32.
const MOST_NODES: f64 = 1.6e7;

/// Knots of a half sine wave over the part: the chord errs by (π/64)²/8 = 3e-4 of the sagitta.
const ARC_KNOTS: usize = 65;

/// Stream of the generator that textures are drawn from.
const TEXTURE_STREAM: u64 = 0x0074_6578_7475_7265;

/// A shaft with the mean radii of `profile` and the form errors of `form` over `0..length_mm`.
///
/// # Errors
/// Refuses a texture whose lengths are not positive or whose grid would be too large, naming the key.
pub fn form_shaft(
    profile: Vec<ProfileKnot>,
    form: &ShaftForm,
    length_mm: f64,
    seed: u64,
) -> Result<Shaft, RenderError> {
    within("part.length_mm", length_mm, 1e-3, 1e5)?;
    let texture = form.texture.as_ref().map(|t| draw_texture(t, length_mm, seed)).transpose()?;
    Ok(Shaft {
        profile,
        lobes: form.lobes.clone(),
        texture,
        eccentricity: form.eccentricity,
        bow: bow_knots(&form.bow, length_mm),
        deflection: deflection_knots(&form.deflection, length_mm),
        pose: form.pose,
    })
}

fn bow_knots(bow: &Bow, length_mm: f64) -> Vec<AxisKnot> {
    let (sin, cos) = bow.phase_deg.to_radians().sin_cos();
    half_sine(bow.sagitta_mm * cos, bow.sagitta_mm * sin, length_mm)
}

fn deflection_knots(deflection: &Deflection, length_mm: f64) -> Vec<AxisKnot> {
    half_sine(deflection.sagitta_x_mm, deflection.sagitta_y_mm, length_mm)
}

fn half_sine(x_mm: f64, y_mm: f64, length_mm: f64) -> Vec<AxisKnot> {
    if x_mm == 0.0 && y_mm == 0.0 {
        return Vec::new();
    }
    (0..ARC_KNOTS)
        .map(|i| {
            let t = i as f64 / (ARC_KNOTS - 1) as f64;
            let arc = (PI * t).sin();
            AxisKnot { z_mm: t * length_mm, x_mm: x_mm * arc, y_mm: y_mm * arc }
        })
        .collect()
}

fn draw_texture(form: &TextureForm, length_mm: f64, seed: u64) -> Result<SurfaceTexture, RenderError> {
    within("shaft.texture.rms_um", form.rms_um, 0.0, 1000.0)?;
    within("shaft.texture.correlation_z_mm", form.correlation_z_mm, 1e-4, 1e5)?;
    within("shaft.texture.correlation_theta_deg", form.correlation_theta_deg, 0.01, 180.0)?;
    let columns = (360.0 * NODES_PER_LENGTH / form.correlation_theta_deg).ceil();
    let step_mm = form.correlation_z_mm / NODES_PER_LENGTH;
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
