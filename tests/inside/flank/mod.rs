//! Flank wear: the renderer's truth, the measurement against it, refusals, and real flanks
//! (`SHADOWGAUGE_FLANKS`).

#[cfg(feature = "onnx")]
mod by_network;
mod by_paper;
mod drawn;
mod feature;
mod found;
mod parts;
mod real;
mod refused;
mod studied;
mod trained;

use shadowgauge::gauge::flank::{CornerSide, FlankSettings};

/// Settings without a corner, at a scale.
pub(super) fn settings(um_per_px: f64) -> FlankSettings {
    FlankSettings {
        um_per_px,
        u_scale: 0.0,
        viewing_deg: 0.0,
        u_viewing_deg: 0.0,
        nose_radius_mm: None,
        corner: CornerSide::None,
        baseline: None,
        full_scale: f32::INFINITY,
    }
}
