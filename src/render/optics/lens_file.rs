//! `lens.toml`: what a calibration found of a lens, as `render` draws it.
//!
//! The gauge corrects f(u, v) = v·(1 + a·r²) + q·v²/ρ + g·u·v/ρ, from the image to a perfect lens
//! (u, v from the centre, ρ half the diagonal). [`Distortion`] goes the other way. To first order
//! and up to what both edges of a shaft share,
//!
//! ```text
//! k1 = −a      p1 = −q/3      p2 = −g/2      tan ε = −t·ρ·p
//! ```
//!
//! p the size of a pixel on the object, ε the chief ray's angle half a diagonal from the centre
//! (positive where what comes closer looks larger), t the change of the corrected diameter by a
//! millimetre towards the camera. A coefficient of 1e-3 leaves 1e-6 of v.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::lens::{Distortion, FieldAberrations, FieldCurvature};
use super::settings::Optics;
use crate::setting::{SettingError, positive, within};

/// The key in a config.
const KEY: &str = "optics.lens_file";

/// Largest relative difference of the pixel on the object: a data sheet's magnification is right to
/// some per mille, a refocused lens to a few per cent.
const SAME_SCALE: f64 = 0.05;

/// A lens before its camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LensFile {
    /// Rows of the camera it was found with.
    pub rows: u32,
    /// Columns of that camera.
    pub columns: u32,
    /// Size of a pixel on the object, µm.
    pub um_per_px: f64,
    /// Angle of the chief ray half a diagonal from the centre, mrad; positive where what comes
    /// closer looks larger.
    #[serde(default)]
    pub telecentricity_mrad: f64,
    /// Distortion, with the keystone in its tangential terms.
    #[serde(default)]
    pub distortion: Distortion,
    /// Where it is in focus over the field: a lens maker's figure, which no width of a pin shows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub field_curvature: Option<FieldCurvature>,
    /// Spherical aberration, coma and astigmatism by the height in the field: the lens maker's
    /// figures.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub aberrations: Vec<FieldAberrations>,
}

/// The gauge's own parameters of a lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CorrectedLens {
    /// Radial distortion a.
    pub(crate) radial: f64,
    /// Change of scale with height q.
    pub(crate) keystone_across: f64,
    /// Change of scale along the shaft g.
    pub(crate) keystone_along: f64,
    /// Telecentricity error t, 1/mm.
    pub(crate) telecentricity_per_mm: f64,
}

impl LensFile {
    /// The lens that a gauge corrects for, before a camera of `rows` x `columns`.
    pub(crate) fn of(lens: &CorrectedLens, (rows, columns): (u32, u32), um_per_px: f64) -> Self {
        let half_diagonal_mm = 0.5 * f64::from(rows).hypot(f64::from(columns)) * 1e-3 * um_per_px;
        Self {
            rows,
            columns,
            um_per_px,
            telecentricity_mrad: -1e3 * (lens.telecentricity_per_mm * half_diagonal_mm).atan(),
            distortion: Distortion {
                k1: -lens.radial,
                p1: -lens.keystone_across / 3.0,
                p2: -0.5 * lens.keystone_along,
                ..Distortion::default()
            },
            field_curvature: None,
            aberrations: Vec::new(),
        }
    }

    /// Puts the lens into optics before a camera of `rows` x `columns` and a pixel of `um_per_px`.
    ///
    /// # Errors
    /// A file of another camera; distortion or telecentricity stated beside it.
    pub(crate) fn put_into(
        self,
        optics: &mut Optics,
        (rows, columns): (u32, u32),
        um_per_px: f64,
    ) -> Result<(), SettingError> {
        positive("um_per_px", self.um_per_px)?;
        within("telecentricity_mrad", self.telecentricity_mrad, -550.0, 550.0, "-550 to 550 mrad")?;
        if (self.rows, self.columns) != (rows, columns) {
            let (r, c) = (self.rows, self.columns);
            let why = format!("is of a camera of {r} rows x {c} columns, not of {rows} x {columns}");
            return Err(SettingError::at(KEY, why));
        }
        if (self.um_per_px / um_per_px - 1.0).abs() > SAME_SCALE {
            let own = self.um_per_px;
            let why = format!("is of a lens with {own:.4} µm a pixel on the object, not {um_per_px:.4}");
            return Err(SettingError::at(KEY, why));
        }
        if !optics.distortion.is_none() || optics.telecentricity_mrad != 0.0 {
            let why = "stands beside optics.distortion or optics.telecentricity_mrad; give one of them";
            return Err(SettingError::at(KEY, why));
        }
        if self.field_curvature.is_some() && optics.field_curvature.is_some() {
            let why = "has a field_curvature and stands beside optics.field_curvature; give one of them";
            return Err(SettingError::at(KEY, why));
        }
        if !self.aberrations.is_empty() && !optics.aberrations.is_empty() {
            let why = "has aberrations and stands beside optics.aberrations; give one of them";
            return Err(SettingError::at(KEY, why));
        }
        if !self.aberrations.is_empty() {
            optics.aberrations = self.aberrations;
        }
        optics.field_curvature = self.field_curvature.or(optics.field_curvature);
        optics.distortion = self.distortion;
        optics.telecentricity_mrad = self.telecentricity_mrad;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENS: CorrectedLens = CorrectedLens {
        radial: 2e-4,
        keystone_across: -1.5e-4,
        keystone_along: 3e-4,
        telecentricity_per_mm: 1e-5,
    };

    /// Widths of ideal edges, distorted by the file's coefficients, are corrected to what they
    /// were: some 1e-7 of a width is of second order.
    #[test]
    fn what_is_drawn_by_the_file_is_corrected_by_the_gauge() {
        let (rows, columns) = (1200_u32, 1600_u32);
        let file = LensFile::of(&LENS, (rows, columns), 10.0);
        let rho = 0.5 * f64::from(rows).hypot(f64::from(columns));
        let centre = (599.5, 799.5);
        let corrected = |row: f64, column: f64| {
            let (u, v) = (column - centre.1, row - centre.0);
            let r2 = (u * u + v * v) / (rho * rho);
            v * (1.0 + LENS.radial * r2) + (LENS.keystone_across * v + LENS.keystone_along * u) * v / rho
        };
        for column in [100.0, 799.5, 1500.0] {
            for (top, bottom) in [(150.0, 1050.0), (300.0, 700.0)] {
                let seen = |row: f64| file.distortion.distort_px(row, column, 1200, 1600);
                let ((a, at), (b, bt)) = (seen(top), seen(bottom));
                let width = corrected(b, bt) - corrected(a, at);
                assert!((width - (bottom - top)).abs() < 5e-4, "{column}: {width}");
                assert!((b - a - (bottom - top)).abs() > 5e-3, "{column}: nothing was drawn");
            }
        }
        // 1e-5 a mm over a half diagonal of 10 mm.
        assert!((file.telecentricity_mrad + 0.1).abs() < 1e-6, "{}", file.telecentricity_mrad);
    }

    #[test]
    fn a_file_of_another_camera_is_refused() {
        let file = || LensFile::of(&LENS, (1200, 1600), 10.0);
        let refused = |size, um_per_px, mut optics: Optics| {
            file().put_into(&mut optics, size, um_per_px).unwrap_err().to_string()
        };
        assert!(refused((1200, 1601), 10.0, Optics::default()).contains("1200 rows x 1600 columns"));
        assert!(refused((1200, 1600), 11.0, Optics::default()).contains("µm a pixel"));
        let stated = Optics { telecentricity_mrad: 0.1, ..Optics::default() };
        assert!(refused((1200, 1600), 10.0, stated).contains("give one of them"));
        let mut optics = Optics::default();
        file().put_into(&mut optics, (1200, 1600), 10.2).unwrap();
        assert_eq!(optics.distortion.k1, -2e-4);
    }
}
