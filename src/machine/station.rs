//! Where a tool, a probe or a head stands on the machine, and the point of the part it works at.

use nalgebra::Vector3;

/// A point of the part and its levers to the slides' references; mm, part coordinates (origin on
/// the axis of rotation at the chuck's face, x radial towards the tool).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Station {
    /// The point of the part where the tool, the probe or the head should be, mm.
    pub point_mm: Vector3<f64>,
    /// Position of the X slide, mm.
    pub x_mm: f64,
    /// Position of the Z slide, mm.
    pub z_mm: f64,
    /// From the X slide's reference to the point, mm; none where it does not ride on that slide.
    pub x_lever_mm: Option<Vector3<f64>>,
    /// From the Z slide's reference, mm: to the part's origin where the Z slide carries the
    /// spindle, to the point where it carries the X slide.
    pub z_lever_mm: Vector3<f64>,
}
