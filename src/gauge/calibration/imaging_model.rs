//! The imaging model by which the gauge corrects for the lens: from pixels to heights on the
//! object.
//!
//! With u, v the column and row from the frame's centre, ρ half the frame's diagonal, r² = (u² +
//! v²)/ρ² and y the distance of the shaft's axis from the plane that the masters lay in (towards
//! the camera),
//!
//! ```text
//! f(u, v) = v·(1 + a·r²) + q·v²/ρ + g·u·v/ρ          what a perfect lens would have shown, px
//! D = s·(1 + t·y)·[f(u, v_bottom) − f(u, v_top)]·χ + o
//! ```
//!
//! a radial distortion, q and g a scale that changes with height and along the shaft (camera not
//! square to the object, decentred lens: Brown's tangential terms, whose other parts cancel between
//! two edges), t the telecentricity error, χ the chord factor of the axis' tilt, s the scale, o the
//! offset of both edges together. Valid to first order in a, q, g: 1e-3 leaves 1e-6 of v.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::setting::{SettingError, within};

/// Number of parameters of an optical setup: s, o, a, q, g, t.
pub(crate) const PARAMETERS: usize = 6;

/// What the lens' data sheet promises: limits, taken as rectangular distributions around zero until
/// masters say more.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct LensLimits {
    /// Largest radial distortion at the corner of the frame, per cent. 0 ..= 5.
    pub distortion_percent: f64,
    /// Largest change of scale from the centre to half a diagonal away (camera not square to the
    /// object), per cent. 0 ..= 5.
    pub keystone_percent: f64,
    /// Largest angle of a chief ray to the optical axis at the corner, degrees. 0 ..= 30.
    pub telecentricity_deg: f64,
}

impl Default for LensLimits {
    /// A good telecentric lens.
    fn default() -> Self {
        Self { distortion_percent: 0.05, keystone_percent: 0.02, telecentricity_deg: 0.03 }
    }
}

impl LensLimits {
    /// Checks every range.
    ///
    /// # Errors
    /// Names the key.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        within("lens.distortion_percent", self.distortion_percent, 0.0, 5.0, "0 to 5 %")?;
        within("lens.keystone_percent", self.keystone_percent, 0.0, 5.0, "0 to 5 %")?;
        within("lens.telecentricity_deg", self.telecentricity_deg, 0.0, 30.0, "0 to 30 degrees")
    }

    /// Standard uncertainties of a, q, g, t before any master was seen: limit/√3;
    /// `half_diagonal_mm` on the object.
    pub(crate) fn u_parameters(&self, half_diagonal_mm: f64) -> [f64; 4] {
        let root = 3.0_f64.sqrt();
        let keystone = 1e-2 * self.keystone_percent / root;
        [
            1e-2 * self.distortion_percent / root,
            keystone,
            keystone,
            self.telecentricity_deg.to_radians().tan() / half_diagonal_mm / root,
        ]
    }
}

/// Columns from the frame's centre that a row is the mean of: r² averages with their variance,
/// which over a whole frame is worth more than a distortion itself at its middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ColumnSpread {
    /// Their mean, px.
    pub mean_px: f64,
    /// Their variance, px².
    pub variance_px2: f64,
}

impl ColumnSpread {
    /// One column.
    pub(crate) fn at(column_px: f64) -> Self {
        Self { mean_px: column_px, variance_px2: 0.0 }
    }
}

/// The lens' parameters and where they count from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LensModel {
    /// Row of the frame's centre, px.
    pub centre_row_px: f64,
    /// Column of the frame's centre, px.
    pub centre_column_px: f64,
    /// Half the frame's diagonal ρ, px.
    pub half_diagonal_px: f64,
    /// Radial distortion a of the correction.
    pub radial: f64,
    /// Change of scale with height q.
    pub keystone_across: f64,
    /// Change of scale along the shaft g.
    pub keystone_along: f64,
    /// Telecentricity error t, 1/mm.
    pub telecentricity_per_mm: f64,
}

impl LensModel {
    /// A perfect lens before a frame of this size.
    pub(crate) fn perfect(rows: usize, columns: usize) -> Self {
        let (r, c) = (rows as f64, columns as f64);
        Self {
            centre_row_px: 0.5 * (r - 1.0),
            centre_column_px: 0.5 * (c - 1.0),
            half_diagonal_px: 0.5 * r.hypot(c),
            radial: 0.0,
            keystone_across: 0.0,
            keystone_along: 0.0,
            telecentricity_per_mm: 0.0,
        }
    }

    /// The same lens before the transposed frame: columns for rows, each keystone for the other.
    #[must_use]
    pub(crate) fn transposed(&self) -> Self {
        Self {
            centre_row_px: self.centre_column_px,
            centre_column_px: self.centre_row_px,
            keystone_across: self.keystone_along,
            keystone_along: self.keystone_across,
            ..*self
        }
    }

    /// Row from the centre that a perfect lens would have shown, f(u, v), px.
    pub(crate) fn ideal(&self, u: f64, v: f64) -> f64 {
        self.ideal_mean(ColumnSpread::at(u), v)
    }

    /// Mean of [`Self::ideal`] over columns where the mean row is v, px; for a row that hardly
    /// changes over them.
    pub(crate) fn ideal_mean(&self, u: ColumnSpread, v: f64) -> f64 {
        let rho = self.half_diagonal_px;
        let r2 = (u.mean_px * u.mean_px + u.variance_px2 + v * v) / (rho * rho);
        v * (1.0 + self.radial * r2) + (self.keystone_across * v + self.keystone_along * u.mean_px) * v / rho
    }

    /// A point (column, row) of the image as a perfect lens would have shown it, px: f across the
    /// shaft and the same along it, f(v, u) with q and g in each other's place, which is what a
    /// camera that is not square to the object does to first order. A decentred lens differs along
    /// the shaft by up to |q| + |g|.
    pub(crate) fn ideal_point(&self, point_px: [f64; 2]) -> [f64; 2] {
        let (u, v) = (point_px[0] - self.centre_column_px, point_px[1] - self.centre_row_px);
        [self.centre_column_px + self.transposed().ideal(v, u), self.centre_row_px + self.ideal(u, v)]
    }

    /// A row of the image as a perfect lens would have shown it, px.
    pub(crate) fn ideal_row(&self, column_px: f64, row_px: f64) -> f64 {
        self.centre_row_px + self.ideal(column_px - self.centre_column_px, row_px - self.centre_row_px)
    }

    /// Derivatives of the ideal width f(u, bottom) − f(u, top) by a, q, g, px.
    pub(crate) fn width_by(&self, u: ColumnSpread, top: f64, bottom: f64) -> [f64; 3] {
        let rho = self.half_diagonal_px;
        let square = u.mean_px * u.mean_px + u.variance_px2;
        let cubic = |v: f64| v * (square + v * v) / (rho * rho);
        [cubic(bottom) - cubic(top), (bottom * bottom - top * top) / rho, u.mean_px * (bottom - top) / rho]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distorting() -> LensModel {
        LensModel {
            radial: 1e-3,
            keystone_across: 2e-4,
            keystone_along: -3e-4,
            ..LensModel::perfect(512, 400)
        }
    }

    #[test]
    fn derivatives_are_those_of_the_width() {
        let lens = distorting();
        let (u, top, bottom, h) = (77.0, -140.0, 120.5, 1e-5);
        let u = ColumnSpread { mean_px: u, variance_px2: 900.0 };
        let width = |l: &LensModel| l.ideal_mean(u, bottom) - l.ideal_mean(u, top);
        let by = lens.width_by(u, top, bottom);
        let moved = [
            LensModel { radial: lens.radial + h, ..lens },
            LensModel { keystone_across: lens.keystone_across + h, ..lens },
            LensModel { keystone_along: lens.keystone_along + h, ..lens },
        ];
        for (analytic, moved) in by.iter().zip(&moved) {
            let numeric = (width(moved) - width(&lens)) / h;
            assert!((numeric - analytic).abs() < 1e-6 * analytic.abs().max(1.0), "{numeric} {analytic}");
        }
    }

    #[test]
    fn the_transposed_lens_corrects_along_the_other_direction() {
        let lens = distorting();
        let (column, row) = (371.0, 88.5);
        let turned = lens.transposed();
        assert!((turned.ideal_row(row, column) - lens.ideal_point([column, row])[0]).abs() < 1e-12);
        assert!((lens.ideal_row(column, row) - lens.ideal_point([column, row])[1]).abs() < 1e-12);
        assert_eq!(turned.transposed(), lens);
    }

    /// The mean over columns equals that of the single columns.
    #[test]
    fn a_mean_over_columns_is_the_mean_of_the_columns() {
        let lens = LensModel {
            radial: 2e-3,
            keystone_across: 1e-3,
            keystone_along: -1e-3,
            ..LensModel::perfect(512, 401)
        };
        let columns: Vec<f64> = (-200..=200).map(f64::from).collect();
        let n = columns.len() as f64;
        let mean = columns.iter().map(|u| lens.ideal(*u, 170.0)).sum::<f64>() / n;
        let variance_px2 = columns.iter().map(|u| u * u).sum::<f64>() / n;
        let at_once = lens.ideal_mean(ColumnSpread { mean_px: 0.0, variance_px2 }, 170.0);
        assert!((at_once - mean).abs() < 1e-10, "{at_once} {mean}");
        assert!((lens.ideal(0.0, 170.0) - mean).abs() > 0.03);
    }
}
