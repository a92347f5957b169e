//! Brightness over the field: vignetting of the lens times the gradient of the backlight.
//!
//! ```text
//! g(u,v) = V(r) · (1 + gu·u + gv·v - s·r²),   V(r) = 1 - v2 r² - v4 r⁴
//! ```
//!
//! u, v the column and row from the centre, r their distance, all in half diagonals of the sensor.
//! The factor is 1 in the centre; it multiplies light, not the black level. A gradient shifts an
//! edge's 50 % point by about σ²·g'/g, a real effect that the gauge must handle.
//! [`FieldLight::natural`] is the cos⁴ fall-off of an entocentric lens to fourth order.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::render::error::{RenderError, within};

/// Smallest factor: below it the field is dark, not vignetted.
const DARKEST: f64 = 0.05;

/// Points over the field at which the factor is checked, along either side.
const PROBES: usize = 33;

/// Coefficients of the brightness over the field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FieldLight {
    /// Loss by vignetting at the corner, second order.
    pub vignetting_2: f64,
    /// Loss by vignetting at the corner, fourth order.
    pub vignetting_4: f64,
    /// Gain of the backlight along the columns from the centre to half a diagonal.
    pub gradient_along: f64,
    /// Gain of the backlight down the rows from the centre to half a diagonal.
    pub gradient_down: f64,
    /// Loss of the backlight half a diagonal from the centre.
    pub sag: f64,
}

impl FieldLight {
    /// cos⁴ of the angle of view, whose tangent at the corner is `tan_corner`: 1 - 2t²r² + 3t⁴r⁴.
    #[cfg(test)]
    pub(crate) fn natural(tan_corner: f64) -> Self {
        let t2 = tan_corner * tan_corner;
        Self { vignetting_2: 2.0 * t2, vignetting_4: -3.0 * t2 * t2, ..Self::default() }
    }

    /// Checks every value against its range, and that no part of the field is dark.
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        within("light.field.vignetting_2", self.vignetting_2, -1.0, 1.0)?;
        within("light.field.vignetting_4", self.vignetting_4, -1.0, 1.0)?;
        within("light.field.gradient_along", self.gradient_along, -1.0, 1.0)?;
        within("light.field.gradient_down", self.gradient_down, -1.0, 1.0)?;
        within("light.field.sag", self.sag, -1.0, 1.0)?;
        let at = |k: usize| 2.0 * k as f64 / (PROBES - 1) as f64 - 1.0;
        let darkest = (0..PROBES * PROBES)
            .map(|i| (at(i % PROBES), at(i / PROBES)))
            .filter(|(u, v)| u * u + v * v <= 1.0)
            .map(|(u, v)| self.factor(u, v))
            .fold(f64::INFINITY, f64::min);
        within("light.field (darkest point over centre)", darkest, DARKEST, f64::MAX)
    }

    /// Whether the field is even.
    pub(crate) fn is_even(&self) -> bool {
        *self == Self::default()
    }

    /// Brightness at (u, v) half diagonals from the centre, 1 in the centre.
    pub(crate) fn factor(&self, u: f64, v: f64) -> f64 {
        let r2 = u * u + v * v;
        let lens = 1.0 - r2 * (self.vignetting_2 + r2 * self.vignetting_4);
        lens * (1.0 + self.gradient_along * u + self.gradient_down * v - self.sag * r2)
    }

    /// The factor at a pixel of a sensor of `rows` x `columns`.
    #[cfg(test)]
    pub(crate) fn at_px(&self, row: f64, column: f64, rows: usize, columns: usize) -> f64 {
        let (rows, columns) = (rows as f64, columns as f64);
        let half_diagonal = 0.5 * rows.hypot(columns);
        self.factor(
            (column - 0.5 * (columns - 1.0)) / half_diagonal,
            (row - 0.5 * (rows - 1.0)) / half_diagonal,
        )
    }

    /// Factors of one row of a sensor of `[rows, columns]`: `out[i]` belongs to column `column0 +
    /// i`.
    #[cfg(test)]
    pub(crate) fn row(&self, row: usize, column0: usize, [rows, columns]: [usize; 2], out: &mut [f32]) {
        for (i, f) in out.iter_mut().enumerate() {
            *f = self.at_px(row as f64, (column0 + i) as f64, rows, columns) as f32;
        }
    }
}
