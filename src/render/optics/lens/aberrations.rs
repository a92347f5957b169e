//! Aberrations of a lens over the field: spherical aberration, coma and astigmatism as Zernike
//! polynomials of the optical path, in Noll's normalisation (Noll, J. Opt. Soc. Am. 66 (1976)
//! 207), so that a coefficient is the root mean square over the pupil:
//!
//! ```text
//! W(ρ, θ) = s √5 (6ρ⁴ - 6ρ² + 1) + c √8 (3ρ³ - 2ρ) cos(θ - ψ) + a √6 ρ² cos 2(θ - ψ)
//! ```
//!
//! ρ is 1 at the numerical aperture, ψ the direction from the middle of the field to the place that
//! is imaged: the lens is centred. The pupil passes e^(-2πiW/λ), so that a ray at the place p of
//! the pupil lands (1/NA) ∂W/∂p beside its place on the object (Hopkins, Wave Theory of
//! Aberrations, 1950). Between the heights h that are stated s, c/h and a/h² are linear in h²,
//! before the first and beyond the last one as there: one row at the corner is a lens of third
//! order.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::render::error::{RenderError, within};

/// Largest coefficient, nm: two waves in visible light, far beyond what an edge is measured by.
const LARGEST_NM: f64 = 1000.0;

/// √5, √8 and √6 of Noll's normalisation.
const SPHERICAL: f64 = 2.236_067_977_499_79;
const COMA: f64 = 2.828_427_124_746_19;
const ASTIGMATISM: f64 = 2.449_489_742_783_178;

/// Aberrations at one height of the field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FieldAberrations {
    /// Distance from the middle of the field in half diagonals of the sensor, 0 to 1.
    pub field: f64,
    /// Primary spherical aberration (Noll 11), nm rms.
    pub spherical_nm: f64,
    /// Primary coma along the direction from the middle (Noll 7, 8), nm rms; positive where rays at
    /// the rim of the pupil land farther out.
    pub coma_nm: f64,
    /// Primary astigmatism (Noll 5, 6), nm rms; positive where rays in the plane through the
    /// optical axis have their focus nearer to the camera than rays across it.
    pub astigmatism_nm: f64,
}

/// Optical path over the pupil before an edge, in waves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PupilPath {
    spherical: f64,
    /// Across the edge into the light, and along it.
    coma: [f64; 2],
    /// cos 2ψ and sin 2ψ, ψ from across the edge.
    astigmatism: [f64; 2],
}

impl FieldAberrations {
    /// Spherical aberration, coma over the height and astigmatism over its square, nm.
    fn ratios(&self) -> [f64; 3] {
        let h = self.field;
        [self.spherical_nm, self.coma_nm / h, self.astigmatism_nm / (h * h)]
    }
}

/// Checks the rows of a lens.
///
/// # Errors
/// Names what is out of range or out of order.
pub(crate) fn check(rows: &[FieldAberrations]) -> Result<(), RenderError> {
    for row in rows {
        within("optics.aberrations.field", row.field, 0.0, 1.0)?;
        within("optics.aberrations.spherical_nm", row.spherical_nm, -LARGEST_NM, LARGEST_NM)?;
        within("optics.aberrations.coma_nm", row.coma_nm, -LARGEST_NM, LARGEST_NM)?;
        within("optics.aberrations.astigmatism_nm", row.astigmatism_nm, -LARGEST_NM, LARGEST_NM)?;
        if row.field == 0.0 && (row.coma_nm != 0.0 || row.astigmatism_nm != 0.0) {
            let right =
                "has coma or astigmatism, which a centred lens has none of in the middle of its field";
            return Err(RenderError::setting("optics.aberrations.field", &row.field, right));
        }
    }
    match rows.windows(2).find(|pair| pair[1].field <= pair[0].field) {
        Some(pair) => {
            let right = "must be larger than that of the row before it";
            Err(RenderError::setting("optics.aberrations.field", &pair[1].field, right))
        }
        None => Ok(()),
    }
}

/// [`FieldAberrations::ratios`] at a height of the field.
fn ratios_at(rows: &[FieldAberrations], field: f64) -> [f64; 3] {
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else { return [0.0; 3] };
    // What has no coma and astigmatism by its height leaves their ratios to the next row.
    let outer = rows.iter().find(|row| row.field > 0.0).map_or([0.0; 3], FieldAberrations::ratios);
    let of = |row: &FieldAberrations| match row.field {
        0.0 => [row.spherical_nm, outer[1], outer[2]],
        _ => row.ratios(),
    };
    let Some(pair) = rows.windows(2).find(|pair| (pair[0].field..=pair[1].field).contains(&field)) else {
        return of(if field < first.field { first } else { last });
    };
    let squares = [pair[0].field, pair[1].field, field].map(|h| h * h);
    let share = (squares[2] - squares[0]) / (squares[1] - squares[0]);
    let (a, b) = (of(&pair[0]), of(&pair[1]));
    std::array::from_fn(|k| a[k] + share * (b[k] - a[k]))
}

impl PupilPath {
    /// The path before an edge at a place of the field: `out` into the light of the edge, `along`
    /// the edge, from the middle in half diagonals.
    pub(crate) fn before_edge(rows: &[FieldAberrations], [out, along]: [f64; 2], wavelength_nm: f64) -> Self {
        let [spherical, coma, astigmatism] = ratios_at(rows, out.hypot(along)).map(|nm| nm / wavelength_nm);
        Self {
            spherical,
            coma: [coma * out, coma * along],
            astigmatism: [astigmatism * (out * out - along * along), astigmatism * 2.0 * out * along],
        }
    }

    /// Waves at a place of the pupil, across the edge into the light and along it, 1 at the rim.
    pub(crate) fn waves(&self, p: f64, q: f64) -> f64 {
        let square = p * p + q * q;
        self.spherical * SPHERICAL * (6.0 * square * (square - 1.0) + 1.0)
            + (self.coma[0] * p + self.coma[1] * q) * COMA * (3.0 * square - 2.0)
            + ASTIGMATISM * (self.astigmatism[0] * (p * p - q * q) + self.astigmatism[1] * 2.0 * p * q)
    }

    /// Bound of its slope within the pupil, waves over half the pupil: λ/NA that rays land beside
    /// their places.
    pub(crate) fn steepest_waves(&self) -> f64 {
        let [across, along] = self.coma.map(f64::abs);
        let [cos, sin] = self.astigmatism.map(f64::abs);
        12.0 * SPHERICAL * self.spherical.abs()
            + 7.0 * COMA * (across + along)
            + 2.0 * ASTIGMATISM * (cos + sin)
    }

    /// Whether both halves of the pupil along the edge are alike.
    pub(crate) fn is_even_along(&self) -> bool {
        self.coma[1] == 0.0 && self.astigmatism[1] == 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(field: f64, spherical_nm: f64, coma_nm: f64, astigmatism_nm: f64) -> FieldAberrations {
        FieldAberrations { field, spherical_nm, coma_nm, astigmatism_nm }
    }

    /// Noll's polynomials are orthonormal over the unit disc.
    #[test]
    fn a_coefficient_is_the_root_mean_square_over_the_pupil() {
        for rows in [[row(1.0, 50.0, 0.0, 0.0)], [row(1.0, 0.0, 50.0, 0.0)], [row(1.0, 0.0, 0.0, 50.0)]] {
            let path = PupilPath::before_edge(&rows, [0.6, 0.8], 500.0);
            let n = 400;
            let lattice = (0..n * n).map(|i| {
                let of = |k: usize| (k as f64 + 0.5) / f64::from(n as u32) * 2.0 - 1.0;
                (of(i % n), of(i / n))
            });
            let inside: Vec<f64> =
                lattice.filter(|(p, q)| p * p + q * q < 1.0).map(|(p, q)| path.waves(p, q)).collect();
            let count = inside.len() as f64;
            let (mean, square) =
                (inside.iter().sum::<f64>() / count, inside.iter().map(|w| w * w).sum::<f64>() / count);
            assert!(mean.abs() < 1e-3 && (square.sqrt() - 0.1).abs() < 2e-4, "{mean} {}", square.sqrt());
        }
    }

    #[test]
    fn one_row_is_a_lens_of_third_order_and_more_rows_are_met() {
        let third = [row(0.5, 20.0, 10.0, 4.0)];
        assert_eq!(ratios_at(&third, 0.1), [20.0, 20.0, 16.0]);
        assert_eq!(ratios_at(&third, 1.0), [20.0, 20.0, 16.0]);
        let rows = [row(0.0, 10.0, 0.0, 0.0), row(0.5, 20.0, 10.0, 4.0), row(1.0, 40.0, 30.0, 16.0)];
        assert_eq!(ratios_at(&rows, 0.0), [10.0, 20.0, 16.0]);
        assert_eq!(ratios_at(&rows, 0.5), [20.0, 20.0, 16.0]);
        // A half of the way in h² from 0.25 to 1.
        assert!((ratios_at(&rows, 0.625_f64.sqrt())[1] - 25.0).abs() < 1e-12);
        assert_eq!(ratios_at(&[], 0.3), [0.0; 3]);
        assert_eq!(ratios_at(&[row(0.0, 5.0, 0.0, 0.0)], 0.3), [5.0, 0.0, 0.0]);
    }

    #[test]
    fn the_pupil_turns_with_the_place() {
        let rows = [row(1.0, 40.0, 30.0, 16.0)];
        let out = PupilPath::before_edge(&rows, [1.0, 0.0], 1000.0);
        let beside = PupilPath::before_edge(&rows, [0.0, 1.0], 1000.0);
        // The same lens seen along the edge: its pupil is turned by a right angle.
        assert!((out.waves(0.3, 0.4) - beside.waves(-0.4, 0.3)).abs() < 1e-15);
        assert!(out.is_even_along() && !beside.is_even_along());
        // Rays at the rim land farther out by 7√8 c/NA.
        let slope = (out.waves(1.0, 0.0) - out.waves(1.0 - 1e-6, 0.0)) / 1e-6;
        let wanted = 7.0 * COMA * 0.03 + 12.0 * SPHERICAL * 0.04 + 2.0 * ASTIGMATISM * 0.016;
        assert!((slope - wanted).abs() < 1e-4 && (out.steepest_waves() - wanted).abs() < 1e-12);
    }

    #[test]
    fn rows_out_of_order_and_coma_in_the_middle_are_refused() {
        let refused = |rows: &[FieldAberrations]| check(rows).unwrap_err().to_string();
        assert!(refused(&[row(0.5, 1.0, 0.0, 0.0), row(0.5, 1.0, 0.0, 0.0)]).contains("row before it"));
        assert!(refused(&[row(0.0, 1.0, 2.0, 0.0)]).contains("centred lens"));
        assert!(refused(&[row(1.2, 1.0, 2.0, 0.0)]).contains("optics.aberrations.field"));
        assert!(check(&[row(0.0, 1.0, 0.0, 0.0), row(1.0, 1.0, 2.0, 3.0)]).is_ok());
    }
}
