//! What a sensor's readout does to the electrons that its pixels gathered.
//!
//! ```text
//! cross-talk      μ' = μ + a·(μ_left + μ_right - 2μ) + d·(μ_above + μ_below - 2μ)
//! row noise       σ_d² = σ_row² + σ_pixel²                     one draw a row of a frame
//! non-linearity   s' = s·(1 + q·(s/F) + c·(s/F)²)              s above the black level, F full
//! well
//! ```
//!
//! Cross-talk is that of light and of charge before it is collected: each electron ends in one
//! pixel, so the counts of neighbours stay independent Poisson numbers and only their means mix.
//! What wires couple between columns is not in it. A pattern of the response belongs to the pixel
//! that collects: PRNU follows the cross-talk. The row noise is a share of the temporal dark noise,
//! which a data sheet states for single pixels.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::spatial::remainder;
use crate::render::error::{RenderError, within};

/// The `[sensor.readout]` table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Readout {
    /// Temporal noise common to the pixels of a row of a frame, electrons: a share of
    /// `sensor.read_noise_e`.
    pub row_noise_e: f64,
    /// Non-linearity q: relative departure of the response that grows in proportion to the signal;
    /// its value at the full well.
    pub quadratic_rel: f64,
    /// Non-linearity c: relative departure that grows with the signal's square; its value at the
    /// full well.
    pub cubic_rel: f64,
    /// Share of a pixel's electrons that each of its neighbours in the row collects.
    pub crosstalk_along_rel: f64,
    /// Share of a pixel's electrons that each of its neighbours in the column collects.
    pub crosstalk_down_rel: f64,
}

impl Readout {
    /// Checks every value against its range, and that more light never reads as less.
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right.
    pub(super) fn check(&self, read_noise_e: f64) -> Result<(), RenderError> {
        within("sensor.readout.row_noise_e", self.row_noise_e, 0.0, 1e4)?;
        within("sensor.readout.quadratic_rel", self.quadratic_rel, -0.5, 0.5)?;
        within("sensor.readout.cubic_rel", self.cubic_rel, -0.5, 0.5)?;
        within("sensor.readout.crosstalk_along_rel", self.crosstalk_along_rel, 0.0, 0.125)?;
        within("sensor.readout.crosstalk_down_rel", self.crosstalk_down_rel, 0.0, 0.125)?;
        if remainder(read_noise_e, [self.row_noise_e, 0.0]).is_none() {
            let right = format!("is a share of sensor.read_noise_e: at most its {read_noise_e} electrons");
            return Err(RenderError::setting("sensor.readout.row_noise_e", &self.row_noise_e, right));
        }
        if self.least_slope() <= 0.0 {
            let right = "must leave the response rising up to the full well: 1 + 2q + 3c above 0";
            return Err(RenderError::setting("sensor.readout.quadratic_rel", &self.quadratic_rel, right));
        }
        Ok(())
    }

    /// Temporal dark noise that the pixels have for themselves, electrons, of a total.
    pub(super) fn pixel_noise_e(&self, read_noise_e: f64) -> f64 {
        if self.row_noise_e == 0.0 {
            return read_noise_e;
        }
        remainder(read_noise_e, [self.row_noise_e, 0.0]).unwrap_or(0.0)
    }

    /// Smallest slope of the response up to the full well, relative to that in the dark.
    fn least_slope(&self) -> f64 {
        let (q, c) = (self.quadratic_rel, self.cubic_rel);
        let slope = |x: f64| 1.0 + x * (2.0 * q + 3.0 * c * x);
        // Where the slope itself is level, if that is between dark and full.
        let level = if c == 0.0 { 0.0 } else { (-q / (3.0 * c)).clamp(0.0, 1.0) };
        slope(1.0).min(slope(level))
    }

    /// Whether it changes nothing.
    pub(super) fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_response_that_falls_is_refused_and_one_that_rises_is_not() {
        let at = |quadratic_rel: f64, cubic_rel: f64| {
            Readout { quadratic_rel, cubic_rel, ..Readout::default() }.check(2.0)
        };
        assert!(at(-0.02, 0.01).is_ok() && at(0.3, -0.2).is_ok());
        // 1 + 2q + 3c is -0.1 and -0.03 at the full well; the least slope within, 1 - q²/3c, is
        // 0.67.
        assert!(at(-0.4, -0.1).is_err() && at(-0.5, -0.01).is_err());
        assert!(at(-0.5, 0.25).is_ok());
    }

    #[test]
    fn row_noise_is_a_share_of_the_dark_noise() {
        let readout = Readout { row_noise_e: 1.2, ..Readout::default() };
        readout.check(2.0).unwrap();
        assert!((readout.pixel_noise_e(2.0) - 1.6).abs() < 1e-12);
        let refused = readout.check(1.0).unwrap_err().to_string();
        assert!(refused.contains("row_noise_e") && refused.contains("at most its 1"), "{refused}");
        assert!(Readout::default().is_none() && Readout::default().pixel_noise_e(2.4) == 2.4);
    }
}
