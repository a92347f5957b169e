//! Values that a calibration file cannot have: every diameter rests on the calibration, so a
//! damaged file is refused when it is read.

use nalgebra::SMatrix;

use super::adjusted::CovariancePart;
use super::imaging_model::{LensModel, PARAMETERS};
use super::optical_setup::SetupCalibration;
use crate::gauge::limit::limits;
use crate::gauge::sensor::{FlatField, Response};

limits! {
    /// Numbers that no calibration has.
    FileLimits = "calibration_file";
    /// Departure from a covariance matrix that rounding explains, relative to the parameters' total
    /// variances: of f64 it is below 1e-12, of a file with seven digits below 1e-6.
    rounding: f64 = 1e-6;
    /// Largest variance or covariance, in mm and px: of a metre, or a thousand px. Named in what is
    /// refused.
    largest_variance: f64 = 1e6;
}

/// A key, its value, and what would be right.
type Impossible = (&'static str, f64, &'static str);

/// The first of some values that is not within `range`, as an error.
fn first_outside(
    key: &'static str,
    values: impl IntoIterator<Item = f64>,
    range: std::ops::RangeInclusive<f64>,
    right: &'static str,
) -> Option<Impossible> {
    values.into_iter().find(|v| !range.contains(v)).map(|v| (key, v, right))
}

impl SetupCalibration {
    /// Names what cannot be, if anything; its conditions check themselves.
    pub(crate) fn impossible(&self) -> Option<Impossible> {
        let some = 1.0..=f64::from(u32::MAX);
        first_outside("bench.rows", [self.rows as f64], some.clone(), "1 or more")
            .or_else(|| first_outside("bench.columns", [self.columns as f64], some, "1 or more"))
            .or_else(|| self.lens.impossible())
            .or_else(|| of_parts(&self.parts))
            .or_else(|| {
                first_outside("bench.sigma_px", [self.sigma_px], 0.01..=1e3, "a blur of 0.01 to 1000 px")
            })
            .or_else(|| {
                let slope = [self.defocus_px_per_mm];
                first_outside("bench.defocus_px_per_mm", slope, 0.0..=1e4, "0 to 10 000 px/mm")
            })
            .or_else(|| {
                let finite = f64::MIN..=f64::MAX;
                first_outside(
                    "bench.birge_ratio",
                    [self.birge_ratio],
                    0.0..=f64::MAX,
                    "a finite ratio, 0 or more",
                )
                .or_else(|| {
                    let values = self.residuals.iter().flat_map(|r| [r.residual_mm, r.u_mm]);
                    first_outside("bench.residuals", values, finite, "finite numbers")
                })
            })
            .or_else(|| self.flat_field.as_ref().and_then(|f| f.impossible((self.rows, self.columns))))
    }
}

impl LensModel {
    fn impossible(&self) -> Option<Impossible> {
        let small = [self.radial, self.keystone_across, self.keystone_along];
        let centre = [self.centre_row_px, self.centre_column_px];
        first_outside("bench.lens", small, -0.2..=0.2, "distortion and keystone below 0.2")
            .or_else(|| {
                let half = [self.half_diagonal_px];
                first_outside("bench.lens.half_diagonal_px", half, 0.5..=1e9, "0.5 px or more")
            })
            .or_else(|| first_outside("bench.lens", centre, -1e9..=1e9, "a centre in px"))
            .or_else(|| {
                let t = [self.telecentricity_per_mm];
                first_outside("bench.lens.telecentricity_per_mm", t, -1.0..=1.0, "below 1 per mm")
            })
    }
}

/// A part that is no covariance matrix would make the uncertainty of some width 0.
fn of_parts(parts: &[CovariancePart]) -> Option<Impossible> {
    let limits = FileLimits::get();
    let entries = parts.iter().flat_map(|p| p.matrix.iter().flatten().copied());
    let large = -limits.largest_variance..=limits.largest_variance;
    let wrong = first_outside("bench.parts", entries, large, "covariances below 1e6").or_else(|| {
        let diagonal = parts.iter().flat_map(|p| (0..PARAMETERS).map(|i| p.matrix[i][i]));
        first_outside("bench.parts", diagonal, 0.0..=f64::MAX, "variances of 0 or more")
    });
    if wrong.is_some() {
        return wrong;
    }
    let total: [f64; PARAMETERS] =
        std::array::from_fn(|i| parts.iter().map(|p| p.matrix[i][i]).sum::<f64>().sqrt());
    let unit = total.map(|u| if u > 0.0 { u } else { 1.0 });
    parts.iter().find_map(|part| {
        let scaled =
            SMatrix::<f64, PARAMETERS, PARAMETERS>::from_fn(|i, j| part.matrix[i][j] / (unit[i] * unit[j]));
        let skew = (scaled - scaled.transpose()).amax();
        let least = scaled.symmetric_eigenvalues().min();
        // Not a number is no covariance either.
        let right = skew <= limits.rounding && least >= -limits.rounding;
        (!right).then_some(("bench.parts", least, "symmetric, positive semidefinite matrices"))
    })
}

impl FlatField {
    /// Names what cannot be of a flat field for frames of this size, if anything.
    fn impossible(&self, (rows, columns): (usize, usize)) -> Option<Impossible> {
        if self.rows != rows {
            return Some(("bench.flat_field.rows", self.rows as f64, "the bench's rows"));
        }
        if self.columns != columns {
            return Some(("bench.flat_field.columns", self.columns as f64, "the bench's columns"));
        }
        let black = [self.black_counts];
        let patterns = [self.prnu_rel, self.dsnu_counts];
        first_outside("bench.flat_field.black_counts", black, -1e6..=1e6, "a grey value")
            .or_else(|| first_outside("bench.flat_field", patterns, 0.0..=1e6, "PRNU and DSNU of 0 or more"))
            .or_else(|| self.impossible_light())
            .or_else(|| self.impossible_defects())
            .or_else(|| self.response.as_ref().and_then(Response::impossible))
    }
}

#[cfg(test)]
mod tests {
    use crate::gauge::calibration::error::CalibrationError;
    use crate::gauge::calibration::gauge_calibration::Calibration;

    /// A file as `calibrate` writes it, with parts, residuals and a flat field.
    const FULL: &str = include_str!("../../../fuzz/seeds/calibration/full.json");

    fn key_of(text: &str) -> Option<&'static str> {
        match Calibration::read(text.as_bytes()) {
            Ok(_) => None,
            Err(CalibrationError::Value { key, .. }) => Some(key),
            Err(other) => panic!("{other}"),
        }
    }

    /// Each of these was accepted once, or ended `measure` with a panic.
    #[test]
    fn a_damaged_file_is_refused_by_key() {
        assert_eq!(key_of(FULL), None);
        for (from, to, key) in [
            ("[[4, 1479], [15, 297]]", "[[4, 1479], [15, 297], [2058, 5]]", "bench.flat_field.defects"),
            ("[[4, 1479], [15, 297]]", "[[4, 1479], [5, 2448]]", "bench.flat_field.defects"),
            ("[[4, 1479], [15, 297]]", "[[15, 297], [4, 1479]]", "bench.flat_field.defects"),
            ("[[4, 1479], [15, 297]]", "[[4, 1479], [4, 1479]]", "bench.flat_field.defects"),
            ("\"light\": [0.9999786632217922", "\"light\": [0.1", "bench.flat_field.light"),
            ("\"light\": [0.9999786632217922", "\"light\": [-1.0", "bench.flat_field.light"),
            ("\"fall_off\": 4.800586508935112e-05", "\"fall_off\": 1.0", "bench.flat_field.fall_off"),
            ("\"fall_off\": 4.800586508935112e-05", "\"fall_off\": 0.5", "bench.flat_field.fall_off"),
            ("\"black_counts\": 64.0,", "\"black_counts\": 1e300,", "bench.flat_field.black_counts"),
            ("\"flat_field\": {\"rows\": 2048", "\"flat_field\": {\"rows\": 2047", "bench.flat_field.rows"),
            ("\"bench\": {\"rows\": 2048", "\"bench\": {\"rows\": 0", "bench.rows"),
            ("\"sigma_px\": 1.06", "\"sigma_px\": -1.06", "bench.sigma_px"),
            ("\"defocus_px_per_mm\": 0.6", "\"defocus_px_per_mm\": -0.6", "bench.defocus_px_per_mm"),
            ("-1.1517721010834296e-05", "-1.1517721010834296e5", "bench.lens.telecentricity_per_mm"),
            ("-1.1432461343194813e-10", "-3e-10", "bench.parts"),
            ("6.453779629623686e-14", "-6.453779629623686e-14", "bench.parts"),
            ("6.453779629623686e-14", "6.453779629623686e14", "bench.parts"),
        ] {
            let damaged = FULL.replacen(from, to, 1);
            assert_ne!(damaged, FULL, "{from}");
            assert_eq!(key_of(&damaged), Some(key), "{to}");
        }
        // A covariance larger than its variances allow: u = 0 at some width.
        let both =
            FULL.replace("-1.1432461343194813e-10", "-3e-10").replace("-1.1432461343194814e-10", "-3e-10");
        match Calibration::read(both.as_bytes()) {
            Err(CalibrationError::Value { key: "bench.parts", value, .. }) if value < -0.1 => {}
            other => panic!("{other:?}"),
        }
    }
}
