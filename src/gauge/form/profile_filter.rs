//! Gaussian profile filter (ISO 16610-21) for closed profiles.
//!
//! The weighting function s(x) = exp(−π(x/αλ_c)²)/(αλ_c), α = √(ln 2/π), passes an undulation of k
//! per revolution with exp(−π(αk/k_c)²) = 2^(−(k/k_c)²): one half at the cutoff k_c. On a closed
//! profile that product with the spectrum is exact, without end effects.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use super::error::FormError;

/// Cutoff of the filter.
#[derive(
    Clone, Copy, Debug, PartialEq, PartialOrd, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(transparent)]
pub(crate) struct Cutoff(f64);

impl Cutoff {
    /// 15 undulations per revolution.
    #[cfg(test)]
    pub(crate) const UPR_15: Self = Self(15.0);
    /// 50 undulations per revolution, the usual default.
    pub(crate) const UPR_50: Self = Self(50.0);
    /// 150 undulations per revolution.
    #[cfg(test)]
    pub(crate) const UPR_150: Self = Self(150.0);

    /// Any cutoff above 0, in undulations per revolution.
    ///
    /// # Errors
    /// Refuses zero, negative and non-finite cutoffs.
    pub(crate) fn upr(undulations: f64) -> Result<Self, FormError> {
        if undulations.is_finite() && undulations > 0.0 {
            return Ok(Self(undulations));
        }
        let right = "finite and above 0 undulations per revolution (ISO 12181-2: 15, 50, 150, 500)";
        Err(FormError::Argument { name: "cutoff", value: undulations, right })
    }

    /// Undulations per revolution at which half the amplitude passes.
    pub(crate) fn undulations(self) -> f64 {
        self.0
    }
}

impl Default for Cutoff {
    fn default() -> Self {
        Self::UPR_50
    }
}

/// Share of an undulation's amplitude that passes: 2^(−(k/k_c)²).
pub(crate) fn gaussian_transmission(lobes: f64, cutoff: Cutoff) -> f64 {
    (-(lobes / cutoff.0).powi(2)).exp2()
}

/// Low-pass filters one full revolution of evenly spaced values: undulations from 0 up to the
/// cutoff remain.
pub(crate) fn gaussian_closed(profile: &[f64], cutoff: Cutoff) -> Vec<f64> {
    let n = profile.len();
    if n == 0 {
        return Vec::new();
    }
    // The mean is kept aside: filtering a radius of 25 mm by FFT would round its micrometres.
    let mean = profile.iter().sum::<f64>() / n as f64;
    let mut buffer: Vec<Complex<f64>> = profile.iter().map(|v| Complex::new(v - mean, 0.0)).collect();
    let mut planner = FftPlanner::new();
    planner.plan_fft_forward(n).process(&mut buffer);
    for (k, value) in buffer.iter_mut().enumerate() {
        let lobes = k.min(n - k) as f64;
        *value *= gaussian_transmission(lobes, cutoff) / n as f64;
    }
    planner.plan_fft_inverse(n).process(&mut buffer);
    buffer.iter().map(|c| mean + c.re).collect()
}
