//! A check pin that took no part in the fit: E_n after ISO/IEC 17043.

use serde::{Deserialize, Serialize};

use super::masters::MasterCertificate;

/// A pin of known diameter measured with the new calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CheckPin {
    /// Its certificate.
    pub certificate: MasterCertificate,
    /// Diameter measured, at 20 °C, mm.
    pub measured_mm: f64,
    /// Standard uncertainty of the difference of measured and certified diameter, mm.
    pub u_error_mm: f64,
    /// Its coverage factor: 2, or that of few degrees of freedom.
    pub coverage_factor: f64,
}

/// Verdict on a calibration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CheckResult {
    /// Certified diameter, mm.
    pub certified_mm: f64,
    /// Measured diameter, mm.
    pub measured_mm: f64,
    /// Measured minus certified, mm.
    pub error_mm: f64,
    /// Expanded uncertainty of measured and certified together, mm.
    pub expanded_u_mm: f64,
    /// Its coverage factor.
    #[serde(default = "two")]
    pub coverage_factor: f64,
    /// |error| over that: accepted up to 1.
    pub e_n: f64,
    /// Whether the calibration passed.
    pub accepted: bool,
}

/// Coverage factor of files that state none.
fn two() -> f64 {
    2.0
}

impl CheckPin {
    /// E_n = |x − X|/U(x − X): √(U_x² + U_X²) at one coverage factor, less what both certificates
    /// and masters share.
    pub(crate) fn judge(&self) -> CheckResult {
        let error_mm = self.measured_mm - self.certificate.diameter_mm;
        let expanded_u_mm = self.coverage_factor * self.u_error_mm;
        let e_n = error_mm.abs() / expanded_u_mm;
        CheckResult {
            certified_mm: self.certificate.diameter_mm,
            measured_mm: self.measured_mm,
            error_mm,
            expanded_u_mm,
            coverage_factor: self.coverage_factor,
            e_n,
            accepted: e_n <= 1.0,
        }
    }
}
