//! Masters with their certificates, and what the certificates of one laboratory share.

use serde::{Deserialize, Serialize};

use super::gauge_calibration::MasterCertificate;

/// A master as the adjustment sees it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MasterPrior {
    /// Its name in budgets and reports.
    pub name: String,
    /// Its certificate, at 20 °C.
    pub certificate: MasterCertificate,
    /// What it shares with the certificates of other masters; `None` where they are independent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub common: Option<CertificateShare>,
}

/// The part of a certificate's error that the certificates of one laboratory (one reference standard, one instrument) share.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertificateShare {
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

    /// Standard uncertainty that the certificate has for itself, mm.
    pub(super) fn u_own_mm(&self) -> f64 {
        (self.certificate.u_mm().powi(2) - self.u_common_mm().powi(2)).max(0.0).sqrt()
    }
}

/// Name of the part that the certificates of a laboratory share.
pub fn shared_source(certified_by: &str) -> String {
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
