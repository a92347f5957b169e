//! Taper along a shaft: the weighted least-squares line of diameter over z.
//!
//! Rate of taper C = dD/dz (ISO 3040); cone angle 2·atan(C/2). Weights 1/u_random²; the common
//! uncertainty is a shared offset of every diameter, which no slope feels, or a shared scale, which
//! changes C by its own relative amount.

use crate::profile::DiameterProfile;

use super::error::FormError;

/// Taper of a profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taper {
    /// Rate of taper dD/dz, mm per mm; positive if the diameter grows with z.
    pub rate: f64,
    /// Its standard uncertainty from the readings' random parts.
    pub u_rate: f64,
    /// Cone angle, degrees.
    pub cone_angle_deg: f64,
    /// Diameter of the line at `middle_z_mm`, mm.
    pub middle_d_mm: f64,
    /// Weighted mean z, where diameter and rate are uncorrelated, mm.
    pub middle_z_mm: f64,
    /// Standard uncertainty of the middle diameter from the random parts, mm.
    pub u_middle_mm: f64,
    /// Σ(residual/u_random)² over (stations − 2): about 1 for a straight cone read with correct
    /// uncertainty.
    pub reduced_chi2: f64,
}

/// Taper of a profile's stations that have a value. At least three, with u_random_mm above 0.
///
/// # Errors
/// Too few stations; an uncertainty of zero; all stations at one z.
pub fn taper(profile: &DiameterProfile) -> Result<Taper, FormError> {
    let readings: Vec<(f64, f64, f64)> = profile
        .stations
        .iter()
        .filter_map(|s| s.reading.value().map(|d| (s.z_mm, d.d_mm, d.u_random_mm)))
        .collect();
    if readings.len() < 3 {
        return Err(FormError::TooFew { feature: "taper", found: readings.len(), needed: 3 });
    }
    if let Some((.., u)) = readings.iter().find(|(z, d, u)| !(z.is_finite() && d.is_finite() && *u > 0.0)) {
        return Err(FormError::Argument {
            name: "u_random_mm",
            value: *u,
            right: "above 0 at finite readings",
        });
    }
    let weight: f64 = readings.iter().map(|(.., u)| u.powi(-2)).sum();
    let mean = |f: &dyn Fn(&(f64, f64, f64)) -> f64| {
        readings.iter().map(|r| f(r) / (r.2 * r.2)).sum::<f64>() / weight
    };
    let middle_z_mm = mean(&|r| r.0);
    let middle_d_mm = mean(&|r| r.1);
    let spread = mean(&|r| (r.0 - middle_z_mm).powi(2));
    if spread <= 0.0 {
        return Err(FormError::Degenerate { feature: "taper" });
    }
    let rate = mean(&|r| (r.0 - middle_z_mm) * (r.1 - middle_d_mm)) / spread;
    let chi2 = weight * mean(&|r| (r.1 - middle_d_mm - rate * (r.0 - middle_z_mm)).powi(2));
    Ok(Taper {
        rate,
        u_rate: (weight * spread).sqrt().recip(),
        cone_angle_deg: 2.0 * (0.5 * rate).atan().to_degrees(),
        middle_d_mm,
        middle_z_mm,
        u_middle_mm: weight.sqrt().recip(),
        reduced_chi2: chi2 / (readings.len() - 2) as f64,
    })
}
