//! Masters with their certificates, and what the certificates of one laboratory share.

use super::error::CalibrationError;
use crate::gauge::edges::FrameEdges;
use crate::gauge::width::column_means::mean_width;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A master pin with its certificate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "MasterPin")]
#[serde(deny_unknown_fields)]
pub struct MasterCertificate {
    /// Certified diameter at 20 °C, mm.
    pub diameter_mm: f64,
    /// Expanded uncertainty U of the certificate, mm.
    pub expanded_u_mm: f64,
    /// Coverage factor k of U.
    #[serde(default = "two")]
    pub coverage_factor: f64,
}

/// The coverage factor k of a certificate that states none.
pub(crate) fn two() -> f64 {
    2.0
}

impl MasterCertificate {
    /// Standard uncertainty U/k, mm.
    pub(crate) fn u_mm(&self) -> f64 {
        self.expanded_u_mm / self.coverage_factor
    }

    pub(crate) fn check(&self, master: usize) -> Result<(), CalibrationError> {
        let fine = |v: f64| v.is_finite() && v > 0.0;
        if fine(self.diameter_mm) && fine(self.expanded_u_mm) && fine(self.coverage_factor) {
            Ok(())
        } else {
            Err(CalibrationError::Certificate { master: master + 1 })
        }
    }
}

/// A master and the frames that show it (angles, positions).
#[derive(Clone, Debug, PartialEq)]
pub struct MasterMeasurement {
    /// Its certificate.
    pub certificate: MasterCertificate,
    /// Edges of its frames.
    pub frames: Vec<FrameEdges>,
}

/// A master as the calibration keeps it: certificate and mean shadow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MasterFigure {
    /// Its certificate.
    pub certificate: MasterCertificate,
    /// Mean shadow width across its axis, px.
    pub width_px: f64,
    /// Standard uncertainty of that mean, px.
    pub u_width_px: f64,
}

impl MasterFigure {
    /// Mean over the columns of frames of one master (angles, positions): the uncertainty is the
    /// larger one of that of the edges and of the scatter of the frames.
    ///
    /// # Errors
    /// Where no frame shows the master.
    pub(crate) fn from_edges(
        certificate: MasterCertificate,
        frames: &[FrameEdges],
    ) -> Result<Self, CalibrationError> {
        let means: Vec<(f64, f64)> = frames.iter().filter_map(mean_width).collect();
        if means.is_empty() {
            return Err(CalibrationError::Unseen { diameter_mm: certificate.diameter_mm });
        }
        let n = means.len() as f64;
        let width_px = means.iter().map(|m| m.0).sum::<f64>() / n;
        let stated = means.iter().map(|m| m.1 * m.1).sum::<f64>().sqrt() / n;
        let scatter = if means.len() > 1 {
            let square: f64 = means.iter().map(|m| (m.0 - width_px).powi(2)).sum();
            (square / (n - 1.0) / n).sqrt()
        } else {
            0.0
        };
        Ok(Self { certificate, width_px, u_width_px: stated.max(scatter) })
    }
}

/// A master as used in the adjustment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MasterPrior {
    /// Its name in budgets and reports.
    pub name: String,
    /// Its certificate, at 20 °C.
    pub certificate: MasterCertificate,
    /// The part shared with the certificates of other masters; `None` where they are independent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub common: Option<CertificateShare>,
}

/// The part of a certificate's error that the certificates of one laboratory (one reference
/// standard, one instrument) share.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CertificateShare {
    /// Who or what they share it by.
    pub certified_by: String,
    /// Its standard uncertainty, mm; at most the certificate's.
    pub u_mm: f64,
}

impl MasterPrior {
    /// Standard uncertainty that the certificate shares with others, mm.
    pub(crate) fn u_common_mm(&self) -> f64 {
        self.common.as_ref().map_or(0.0, |c| c.u_mm)
    }

    /// Standard uncertainty of the certificate by itself, mm.
    pub(super) fn u_own_mm(&self) -> f64 {
        (self.certificate.u_mm().powi(2) - self.u_common_mm().powi(2)).max(0.0).sqrt()
    }
}

/// Name of the part that the certificates of a laboratory share.
pub(crate) fn shared_source(certified_by: &str) -> String {
    format!("certificates of {certified_by}, what they share")
}

/// Laboratories in the order of the masters, and each master's one.
pub(super) fn laboratories(masters: &[MasterPrior]) -> (Vec<String>, Vec<Option<usize>>) {
    let mut names: Vec<String> = Vec::new();
    let mut index = |name: &String| {
        names.iter().position(|n| n == name).unwrap_or_else(|| {
            names.push(name.clone());
            names.len() - 1
        })
    };
    let of = masters.iter().map(|m| m.common.as_ref().map(|c| index(&c.certified_by))).collect();
    (names, of)
}
