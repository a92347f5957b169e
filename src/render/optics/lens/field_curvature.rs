//! Field curvature: the surface of best focus is no plane, and not square to the axis.
//!
//! ```text
//! z_f(u, v) = s·(u² + v²) + a·u + d·v
//! ```
//!
//! z_f towards the camera from the middle of the field, mm; u, v from the middle along the row and
//! down the column in half diagonals of the sensor. An edge whose axis stands y before the plane of
//! focus of the middle is y - z_f out of focus. Petzval's sum gives s in the first place (s = h²/2R
//! at half a diagonal h on the object, R the radius of the surface there); astigmatism beside it is
//! not separated: the edge of a shaft lies along the row, so that s is that of the rays across it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::render::error::{RenderError, within};

/// Where the lens is in focus over the field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FieldCurvature {
    /// How far the surface of best focus lies towards the camera half a diagonal from the middle,
    /// mm on the object.
    pub sag_mm: f64,
    /// The same by its tilt, half a diagonal along the row.
    pub tilt_along_mm: f64,
    /// The same by its tilt, half a diagonal down the column.
    pub tilt_down_mm: f64,
}

impl FieldCurvature {
    /// Checks every value against its range.
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        within("optics.field_curvature.sag_mm", self.sag_mm, -100.0, 100.0)?;
        within("optics.field_curvature.tilt_along_mm", self.tilt_along_mm, -100.0, 100.0)?;
        within("optics.field_curvature.tilt_down_mm", self.tilt_down_mm, -100.0, 100.0)
    }

    /// Place of best focus towards the camera at a pixel of a sensor of `rows` x `columns`, mm.
    pub(crate) fn focus_mm(&self, row: f64, column: f64, (rows, columns): (usize, usize)) -> f64 {
        let half = 0.5 * (rows as f64).hypot(columns as f64);
        let u = (column - 0.5 * (columns as f64 - 1.0)) / half;
        let v = (row - 0.5 * (rows as f64 - 1.0)) / half;
        self.sag_mm * (u * u + v * v) + self.tilt_along_mm * u + self.tilt_down_mm * v
    }

    /// Bound of its magnitude over the sensor, mm.
    pub(crate) fn largest_mm(&self) -> f64 {
        self.sag_mm.abs() + self.tilt_along_mm.abs() + self.tilt_down_mm.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_corner_has_the_sag_and_a_tilt_changes_sign_across_the_field() {
        let size = (600, 800);
        let bowl = FieldCurvature { sag_mm: 0.5, ..FieldCurvature::default() };
        assert!((bowl.focus_mm(-0.5, -0.5, size) - 0.5).abs() < 1e-12);
        assert_eq!(bowl.focus_mm(299.5, 399.5, size), 0.0);
        // 300 of 500 px of half a diagonal.
        assert!((bowl.focus_mm(599.5, 399.5, size) - 0.5 * 0.36).abs() < 1e-12);
        let tilted = FieldCurvature { tilt_down_mm: 0.2, ..FieldCurvature::default() };
        let ends = [-0.5, 599.5].map(|row| tilted.focus_mm(row, 100.0, size));
        assert!((ends[0] + 0.12).abs() < 1e-12 && (ends[1] - 0.12).abs() < 1e-12);
        assert!((bowl.largest_mm() - 0.5).abs() < 1e-12);
    }
}
