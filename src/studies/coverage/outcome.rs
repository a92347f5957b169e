//! What a scene yields, and the warning on its frames.

use std::collections::BTreeMap;

use crate::gauge::budget::Budget;
use crate::gauge::calibration::Conditions;
use crate::gauge::{Calibration, Edge, FrameEdges};

/// Result of a scene.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Outcome {
    /// Measured minus true diameter at 20 °C, mm; none where the frame was refused.
    pub error_mm: Option<f64>,
    /// Combined standard uncertainty, mm.
    pub u_mm: f64,
    /// Half width of the 95 % interval, mm.
    pub half_mm: f64,
    /// The warning on the frame; empty without one.
    pub flag: String,
}

/// A scene that was refused, with the reason.
pub(super) fn refused(flag: String) -> Outcome {
    Outcome { error_mm: None, u_mm: f64::NAN, half_mm: f64::NAN, flag }
}

/// The most frequent reason among the refused edges.
fn most_common(edges: &FrameEdges) -> String {
    let mut counts = BTreeMap::new();
    for reason in edges.top.iter().chain(&edges.bottom).filter_map(Edge::reason) {
        *counts.entry(reason.to_string()).or_insert(0) += 1;
    }
    counts.into_iter().max_by_key(|(_, count)| *count).map_or(String::new(), |(reason, _)| reason)
}

/// The warning on a frame: fewer than 97 % of its columns measured, a residual that the noise does
/// not explain, a blur unlike the masters'.
pub(super) fn flag(calibration: &Calibration, conditions: &Conditions, edges: &FrameEdges) -> String {
    let usable = edges.valid() as f64 / edges.columns() as f64;
    let impaired = (0..edges.columns()).filter(|c| edges.top[*c].reason().is_some()).count();
    if usable < 0.97 || impaired > edges.columns() / 2 {
        return format!("columns refused or impaired: {}", most_common(edges));
    }
    if edges.figures.reduced_chi2 > 1.5 {
        return "residual".to_owned();
    }
    match calibration.setup.as_ref().map(|b| b.check_focus(edges.figures.sigma_px, conditions)) {
        Some(Err(_)) => "blur".to_owned(),
        _ => String::new(),
    }
}

/// A scene with a diameter.
pub(super) fn outcome(budget: &Budget, true_mm: f64, flag: String) -> Outcome {
    Outcome {
        error_mm: Some(budget.diameter_mm - true_mm),
        u_mm: budget.u_mm(),
        half_mm: budget.half_width_mm(0.95),
        flag,
    }
}
