//! The diameter error of a deflection (equations 1 to 3 of the slender-shaft paper).
//!
//! The edge stands at D₃/2 from the axis of rotation; the axis of the shaft at the tool has moved
//! away from it by u_r, and along the cutting speed by u_t. Once the shaft springs back, its radius
//! is the distance that the edge had from its axis.

/// Diameter that remains, mm: D₂ = 2·√((D₃/2 + u_r)² + u_t²) (equation 1).
pub(crate) fn diameter_after_mm(commanded_mm: f64, radial_mm: f64, tangential_mm: f64) -> f64 {
    2.0 * (0.5 * commanded_mm + radial_mm).hypot(tangential_mm)
}

/// Diameter error of a radial deflection, mm: 2·u_r (equation 2).
pub(crate) fn radial_error_mm(radial_mm: f64) -> f64 {
    2.0 * radial_mm
}

/// Diameter error of a tangential deflection, mm: 2·√((D₃/2)² + u_t²) - D₃ (equation 3), rearranged
/// so that no digits cancel at small deflections.
pub(crate) fn tangential_error_mm(commanded_mm: f64, tangential_mm: f64) -> f64 {
    let radius = 0.5 * commanded_mm;
    2.0 * tangential_mm * tangential_mm / (radius.hypot(tangential_mm) + radius)
}
