//! The midline of both edges in one frame: its height and slope at the middle of the field.
//!
//! A head that its machine displaces by u_x and turns by b sees the axis of rotation at −u_x with
//! the slope −b. What turns with the part (eccentricity, bow, odd lobes) has the other sign half a
//! turn on: the means of φ and φ + 180° are free of it. Heights count from a fixed row of the
//! frame: a constant is where the head was set up.

use super::column_diameters::ColumnDiameters;
use crate::gauge::limit::limits;
use crate::profile::Reading;

limits! {
    /// Which frames show a midline.
    FieldMidlineLimits = "field_midline";
    /// Share of the columns with both edges that a frame needs: with fewer, on one side of the
    /// field, the height at its middle is an extrapolation of the slope.
    least_fill: f64 = 0.5;
}

/// A line through the middles of both edges of a frame's columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldMidline {
    /// Height at the middle of the field, mm.
    pub height_mm: f64,
    /// Slope along z, rad.
    pub slope_rad: f64,
}

impl FieldMidline {
    /// The line of least squares through the columns that have a diameter; none where too few have.
    pub(crate) fn of(frame: &ColumnDiameters) -> Option<Self> {
        let middle = 0.5 * (frame.columns.len() as f64 - 1.0);
        let points = || {
            let good = frame.columns.iter().enumerate().filter(|(_, column)| {
                matches!(column.reading, Reading::Value(_)) && column.middle_mm.is_finite()
            });
            good.map(|(k, column)| ((k as f64 - middle) * frame.pitch_mm, column.middle_mm))
        };
        let (count, z, x) =
            points().fold((0.0, 0.0, 0.0), |(n, z, x), point| (n + 1.0, z + point.0, x + point.1));
        if count < 3.0 || count < FieldMidlineLimits::get().least_fill * frame.columns.len() as f64 {
            return None;
        }
        let (z, x) = (z / count, x / count);
        let (product, square) = points().fold((0.0, 0.0), |(product, square), point| {
            (product + (point.0 - z) * (point.1 - x), square + (point.0 - z).powi(2))
        });
        let slope_rad = product / square;
        Some(Self { height_mm: x - slope_rad * z, slope_rad })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauge::diameter::column_diameters::ColumnDiameter;
    use crate::profile::{Diameter, Reason};

    fn column(middle_mm: f64) -> ColumnDiameter {
        let value = Diameter { d_mm: 10.0, u_random_mm: 1e-4, u_common_mm: 0.0 };
        ColumnDiameter { reading: Reading::Value(value), middle_mm, ..ColumnDiameter::gap(Reason::NoEdge) }
    }

    #[test]
    fn a_line_is_read_at_the_middle_of_the_field_whatever_is_missing() {
        let (pitch_mm, height, slope) = (0.02, 0.3, 4e-5);
        let at = |k: usize| column(height + slope * (k as f64 - 49.5) * pitch_mm);
        let mut frame = ColumnDiameters { columns: (0..100).map(at).collect(), shared_length: 1.0, pitch_mm };
        let whole = FieldMidline::of(&frame).unwrap();
        assert!((whole.height_mm - height).abs() < 1e-14 && (whole.slope_rad - slope).abs() < 1e-14);
        for k in 0..40 {
            frame.columns[k] = ColumnDiameter::gap(Reason::NoEdge);
        }
        let part = FieldMidline::of(&frame).unwrap();
        assert!((part.height_mm - height).abs() < 1e-13 && (part.slope_rad - slope).abs() < 1e-13);
        for k in 40..55 {
            frame.columns[k] = ColumnDiameter::gap(Reason::NoEdge);
        }
        assert_eq!(FieldMidline::of(&frame), None, "45 of 100 columns");
    }
}
