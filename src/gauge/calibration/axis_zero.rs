//! What the heights of an axis count from.

/// What heights count from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct AxisZero {
    /// Height of the optical axis as [`crate::gauge::ColumnDiameter::middle_mm`] counts, mm: 0
    /// from a calibration with a lens, −scale·(rows − 1)/2 from a bare scale.
    pub height_mm: f64,
    /// Relative standard uncertainty of the scale.
    pub u_scale: f64,
}
