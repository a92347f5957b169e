//! The correction of a probe, from masters of calibrated diameter.

use serde::{Deserialize, Serialize};

use super::pairs::{Pair, mean_and_scatter};
use super::settings::ProbeSettings;

/// Why a probe cannot be calibrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CalibrationError {
    /// No master.
    #[error("a probe is calibrated on one master or more; none was touched")]
    NoMaster,
    /// A master without a touch.
    #[error(
        "master pin {pin} was not touched where it was expected: is it there, and is probe.reach_mm enough?"
    )]
    NotTouched {
        /// Number of the pin, from 1.
        pin: usize,
    },
}

/// Touches of a master, and its certificate.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MasterTouches {
    /// Certified diameter at 20 °C, mm.
    pub diameter_mm: f64,
    /// Standard uncertainty of it, mm.
    pub u_mm: f64,
    /// Two-point diameters as indicated.
    pub pairs: Vec<Pair>,
}

/// The correction of a two-point diameter by touches: ball, pre-travel, delay, setting of the probe
/// along x.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProbeCalibration {
    /// Indicated two-point diameter less the diameter, mm: apart from the ball's diameter, the
    /// `nc.probe.correction_mm` of a probe set to its ball's lowest point.
    pub probe_correction_mm: f64,
    /// Standard uncertainty of it, mm.
    pub u_correction_mm: f64,
    /// Mean diameter of the masters, mm, where the correction is best.
    pub master_mm: f64,
    /// Largest departure of a master from the mean of all, mm.
    pub largest_residual_mm: f64,
}

/// The mean over the masters. Their certificates count as one (a laboratory's own error is common
/// to them); where masters disagree by more than their scatter, the disagreement is included.
///
/// # Errors
/// No master, or one that was not touched.
pub(crate) fn calibrate(
    settings: &ProbeSettings,
    masters: &[MasterTouches],
) -> Result<ProbeCalibration, CalibrationError> {
    if masters.is_empty() {
        return Err(CalibrationError::NoMaster);
    }
    let t = &settings.temperature;
    let grown = 1.0 + 1e-6 * t.expansion_um_per_m_k * (t.master_c - 20.0);
    let (mut found, mut scatter, mut certified) = (Vec::new(), 0.0, 0.0);
    for (index, master) in masters.iter().enumerate() {
        let read: Vec<f64> = master.pairs.iter().filter_map(|p| p.read_mm).collect();
        let Some((mean, variance)) = mean_and_scatter(&read) else {
            return Err(CalibrationError::NotTouched { pin: index + 1 });
        };
        found.push(mean - master.diameter_mm * grown);
        let least = settings.touch_variance_mm2() * 2.0;
        scatter += variance.max(least) / read.len() as f64;
        certified += master.u_mm;
    }
    let n = masters.len() as f64;
    let mean = found.iter().sum::<f64>() / n;
    let spread: f64 = found.iter().map(|f| (f - mean).powi(2)).sum();
    let disagreement = if masters.len() > 1 { spread / (n - 1.0) / n } else { 0.0 };
    let master_mm = masters.iter().map(|m| m.diameter_mm).sum::<f64>() / n;
    let warm = master_mm * 1e-6 * t.expansion_um_per_m_k * t.u_k;
    let variance = (scatter / (n * n)).max(disagreement) + (certified / n).powi(2) + warm * warm;
    Ok(ProbeCalibration {
        probe_correction_mm: mean,
        u_correction_mm: variance.sqrt(),
        master_mm,
        largest_residual_mm: found.iter().map(|f| (f - mean).abs()).fold(0.0, f64::max),
    })
}

impl ProbeSettings {
    /// Variance of one touch by repeatability and by the increment of the control, mm² (radius).
    pub(crate) fn touch_variance_mm2(&self) -> f64 {
        // a rectangle as wide as the increment (GUM F.2.2.1)
        1e-6 * (self.repeatability_um.powi(2) + self.resolution_um.powi(2) / 12.0)
    }
}
