//! Harmonics of a revolution by FFT, each with its possible causes.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use super::turn::Turn;

/// What a harmonic of a revolution of silhouettes is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// The section's own even lobes, free of spindle motion.
    Form,
    /// Odd lobes and odd synchronous spindle motion (ISO 230-7), which one view cannot separate.
    FormAndSpindle,
    /// Spindle motion alone: nothing of the part is in it.
    Spindle,
    /// Eccentricity of the section about the spindle axis, with the spindle's fundamental motion.
    Eccentricity,
}

/// One harmonic A·cos(k(φ − φ_k)).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Harmonic {
    /// Undulations per revolution k.
    pub lobes: usize,
    /// Amplitude A, mm; of a pure noise harmonic about 1.25 times its uncertainty.
    pub amplitude_mm: f64,
    /// Spindle angle of its first peak φ_k, degrees, 0 ≤ φ_k < 360/k.
    pub phase_deg: f64,
    /// Standard uncertainty of either quadrature component, mm.
    pub u_amplitude_mm: f64,
    /// What it is made of.
    pub origin: Origin,
}

/// Harmonics of a revolution.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct TurnHarmonics {
    /// Mean of the support function, mm: half the mean caliper diameter.
    pub mean_radius_mm: f64,
    /// Of the section's support function, k = 1, 2, ….
    pub section: Vec<Harmonic>,
    /// Of the synchronous spindle motion across the line of sight, even k only; nothing of the part
    /// is in it.
    pub even_spindle: Vec<Harmonic>,
}

impl TurnHarmonics {
    /// Adds to the odd lobes what an axis known to `u_axis_mm` only makes of half a revolution: a
    /// square wave of that height, 4/(πk) of it at order k.
    #[must_use]
    pub(crate) fn with_axis(mut self, u_axis_mm: f64) -> Self {
        for harmonic in self.section.iter_mut().filter(|h| h.lobes % 2 == 1) {
            let of_axis = 4.0 / (std::f64::consts::PI * harmonic.lobes as f64) * u_axis_mm;
            harmonic.u_amplitude_mm = harmonic.u_amplitude_mm.hypot(of_axis);
        }
        self
    }
}

/// Complex amplitudes C_k of a real periodic sequence, f_i = Re Σ C_k·exp(jk·2πi/n), k = 0..=n/2.
pub(super) fn spectrum(values: &[f64]) -> Vec<Complex<f64>> {
    let n = values.len();
    let mut buffer: Vec<Complex<f64>> = values.iter().map(|v| Complex::new(*v, 0.0)).collect();
    FftPlanner::new().plan_fft_forward(n).process(&mut buffer);
    let scale = |k: usize| if k == 0 || 2 * k == n { 1.0 } else { 2.0 };
    (0..=n / 2).map(|k| buffer[k] * (scale(k) / n as f64)).collect()
}

/// Harmonics up to `max_lobes` (at most n/2 − 1) of a revolution whose single edges carry the
/// random standard uncertainty `u_edge_mm`: each component's is u_edge/√n, since two edges
/// contribute to it.
pub(crate) fn harmonics(turn: &Turn, max_lobes: usize, u_edge_mm: f64) -> TurnHarmonics {
    let n = turn.len();
    let u_amplitude_mm = u_edge_mm / (n as f64).sqrt();
    let top = max_lobes.min(n / 2 - 1);
    let harmonic = |spectrum: &[Complex<f64>], lobes: usize, origin: Origin| {
        let c = spectrum[lobes];
        let period = 360.0 / lobes as f64;
        let phase = turn.angle_deg(0) - c.arg().to_degrees() / lobes as f64;
        // rem_euclid rounds a tiny negative phase up to the period itself.
        let phase_deg = phase.rem_euclid(period);
        let phase_deg = if phase_deg < period { phase_deg } else { 0.0 };
        Harmonic { lobes, amplitude_mm: c.norm(), phase_deg, u_amplitude_mm, origin }
    };
    let section = spectrum(&turn.support_mm());
    let spindle = spectrum(&turn.even_spindle_motion_mm());
    let origin = |k: usize| match k {
        1 => Origin::Eccentricity,
        k if k % 2 == 0 => Origin::Form,
        _ => Origin::FormAndSpindle,
    };
    TurnHarmonics {
        mean_radius_mm: section[0].re,
        section: (1..=top).map(|k| harmonic(&section, k, origin(k))).collect(),
        even_spindle: (2..=top).step_by(2).map(|k| harmonic(&spindle, k, Origin::Spindle)).collect(),
    }
}
