//! How the image lies in the machine: where the nose stands in it after moves along X and Z.
//!
//! The centre of the nose at the slides' places (X, Z) is p = p0 + M·(X, Z). M by least squares:
//! its columns are the directions of +X and +Z in the image and px a millimetre along them. Both
//! coordinates of all centres have one standard deviation s: that of the residuals, or the centres'
//! own uncertainty where that is larger; with N = Σφφᵀ over φ = (1, X, Z) the covariance of a
//! column's coordinates is s²·N⁻¹.
//!
//! In: noses in their frames with the places of the slides. Out: [`MachineAxes`].

use glam::DVec2;
use nalgebra::{SMatrix, SVector};

use crate::gauge::limit::limits;
use crate::numerics::normal_equations::NormalEquations;

limits! {
    /// When moves of a tool give the directions of the machine's axes.
    NoseAxesLimits = "nose_axes";
    /// Residual of a centre in its standard uncertainties from which the moves contradict the
    /// pictures: a normal deviate passes it once in two million.
    most_residual_u: f64 = 5.0;
    /// The same, px, below which it is the slides' repeatability: 5 µm at 2.5 µm a px, twice.
    most_residual_px: f64 = 4.0;
    /// Least ratio of the spread across the line of the moves to that along it: a tenth of a degree
    /// then needs moves that are right to 2e-4 of their length.
    least_spread: f64 = 0.1;
    /// Largest departure of the scales along X and Z from each other: telecentric lenses and slides
    /// differ by less than 1e-3; X in diameters differs by 2.
    most_scale: f64 = 0.02;
}

/// A nose at a place of the slides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MovedNose {
    /// Place of the slides (X, Z), mm, X radial.
    pub slides_mm: DVec2,
    /// Centre of the nose, (column, −row), px.
    pub centre: DVec2,
    /// Its standard uncertainty, px.
    pub u_px: f64,
}

/// An axis of the machine in the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MachineAxis {
    /// Its direction, degrees: 0 to the right, counter-clockwise as seen.
    pub direction_deg: f64,
    /// Standard uncertainty, degrees.
    pub u_direction_deg: f64,
    /// Scale along it, µm per px.
    pub um_per_px: f64,
    /// Standard uncertainty, µm per px.
    pub u_um_per_px: f64,
}

/// Image and machine.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MachineAxes {
    /// +X, away from the axis.
    pub x: MachineAxis,
    /// +Z, towards the tailstock.
    pub z: MachineAxis,
    /// From a difference in the image (column, −row), px, to one of the machine (X, Z), mm, by
    /// rows.
    pub to_machine_mm_per_px: [[f64; 2]; 2],
    /// Angle from +Z to +X in the image less a right angle, degrees; of a mirrored picture from +X
    /// to +Z.
    pub off_square_deg: f64,
    /// Standard uncertainty, degrees.
    pub u_off_square_deg: f64,
    /// Whether +X lies clockwise of +Z.
    pub mirrored: bool,
    /// Standard deviation s of a centre's coordinate, px.
    pub s_px: f64,
    /// Distances of the centres from where the moves have them, px.
    pub residuals_px: Vec<f64>,
}

/// Why moves give no axes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum AxesError {
    /// Too few.
    #[error("{0} pictures, 3 or more are needed: one place, one moved along X and one moved along Z")]
    Few(usize),
    /// Moves on a line.
    #[error(
        "the moves lie on a line (spread across it {share:.3} of that along it, {least} or more is needed): move along X and \
         along Z"
    )]
    OnALine {
        /// Spread across over spread along.
        share: f64,
        /// Least share.
        least: f64,
    },
    /// A picture that contradicts the others.
    #[error(
        "picture {number} stands {off_px:.2} px from where the moves have it ({most_px:.2} px at most): its --x-mm or --z-mm is \
         another, or the tool turned or was changed between"
    )]
    Residual {
        /// Its number from 1.
        number: usize,
        /// Distance, px.
        off_px: f64,
        /// Most allowed, px.
        most_px: f64,
    },
    /// Scales that differ.
    #[error(
        "the scale is {x_um:.4} µm per px along X and {z_um:.4} along Z: one camera has one scale; --x-mm are distances from the \
         axis, half of diameters"
    )]
    Scales {
        /// Along X, µm per px.
        x_um: f64,
        /// Along Z, µm per px.
        z_um: f64,
    },
}

/// The machine's axes in the image.
///
/// # Errors
/// Too few places, moves on a line, a picture that contradicts the others, scales that differ.
pub(crate) fn machine_axes(moved: &[MovedNose]) -> Result<MachineAxes, AxesError> {
    let limits = NoseAxesLimits::get();
    if moved.len() < 3 {
        return Err(AxesError::Few(moved.len()));
    }
    check_spread(moved)?;
    let on_a_line = AxesError::OnALine { share: 0.0, least: limits.least_spread };
    let (mut columns, mut ups) = (NormalEquations::<3>::new(), NormalEquations::<3>::new());
    let terms = |m: &MovedNose| SVector::from([1.0, m.slides_mm.x, m.slides_mm.y]);
    for m in moved {
        columns.add(terms(m), m.centre.x, 1.0);
        ups.add(terms(m), m.centre.y, 1.0);
    }
    let inverse = columns.normal.try_inverse().ok_or(on_a_line)?;
    let (a, b) = (inverse * columns.right, inverse * ups.right);
    let off = |m: &MovedNose| m.centre - DVec2::new(a.dot(&terms(m)), b.dot(&terms(m)));
    let residuals_px: Vec<f64> = moved.iter().map(|m| off(m).length()).collect();
    let n = moved.len() as f64;
    let stated = (moved.iter().map(|m| m.u_px * m.u_px).sum::<f64>() / n).sqrt();
    check_residuals(&residuals_px, stated)?;
    let freedom = 2.0 * n - 6.0;
    let squares: f64 = residuals_px.iter().map(|r| r * r).sum();
    let s_px = if freedom > 0.0 { stated.max((squares / freedom).sqrt()) } else { stated };
    let (x, z) = (DVec2::new(a[1], b[1]), DVec2::new(a[2], b[2]));
    axes((x, z), &(inverse * (s_px * s_px)), s_px, residuals_px)
}

/// Refuses places whose spread across their common line is small.
fn check_spread(moved: &[MovedNose]) -> Result<(), AxesError> {
    let mean = moved.iter().map(|m| m.slides_mm).sum::<DVec2>() / moved.len() as f64;
    let (mut xx, mut xz, mut zz) = (0.0, 0.0, 0.0);
    for d in moved.iter().map(|m| m.slides_mm - mean) {
        (xx, xz, zz) = (xx + d.x * d.x, xz + d.x * d.y, zz + d.y * d.y);
    }
    let root = (0.25 * (xx - zz).powi(2) + xz * xz).sqrt();
    let (large, small) = (0.5 * (xx + zz) + root, (0.5 * (xx + zz) - root).max(0.0));
    let share = if large > 0.0 { (small / large).sqrt() } else { 0.0 };
    let least = NoseAxesLimits::get().least_spread;
    if share >= least { Ok(()) } else { Err(AxesError::OnALine { share, least }) }
}

fn check_residuals(residuals_px: &[f64], stated_px: f64) -> Result<(), AxesError> {
    let limits = NoseAxesLimits::get();
    let most_px = (limits.most_residual_u * stated_px).max(limits.most_residual_px);
    match residuals_px.iter().zip(1..).max_by(|a, b| a.0.total_cmp(b.0)) {
        Some((&off_px, number)) if off_px > most_px => Err(AxesError::Residual { number, off_px, most_px }),
        _ => Ok(()),
    }
}

/// Directions, scales and their uncertainties from M's columns, px a millimetre, and the covariance
/// of (p0, X, Z) of either coordinate.
fn axes(
    (x, z): (DVec2, DVec2),
    covariance: &SMatrix<f64, 3, 3>,
    s_px: f64,
    residuals_px: Vec<f64>,
) -> Result<MachineAxes, AxesError> {
    let axis = |v: DVec2, k: usize| {
        let (length, u) = (v.length(), covariance[(k, k)].sqrt());
        MachineAxis {
            direction_deg: v.to_angle().to_degrees(),
            u_direction_deg: (u / length).to_degrees(),
            um_per_px: 1e3 / length,
            u_um_per_px: 1e3 * u / (length * length),
        }
    };
    let (ax, az) = (axis(x, 1), axis(z, 2));
    if (ax.um_per_px / az.um_per_px - 1.0).abs() > NoseAxesLimits::get().most_scale {
        return Err(AxesError::Scales { x_um: ax.um_per_px, z_um: az.um_per_px });
    }
    let turn = z.angle_to(x).to_degrees();
    // both columns share p0: their directions' errors are correlated by cos of the angle between
    let shared = covariance[(1, 2)] * x.dot(z) / (x.length_squared() * z.length_squared());
    let variance =
        ax.u_direction_deg.powi(2) + az.u_direction_deg.powi(2) - 2.0 * shared * 1f64.to_degrees().powi(2);
    let determinant = x.perp_dot(z);
    Ok(MachineAxes {
        x: ax,
        z: az,
        to_machine_mm_per_px: [
            [z.y / determinant, -z.x / determinant],
            [-x.y / determinant, x.x / determinant],
        ],
        off_square_deg: turn.abs() - 90.0,
        u_off_square_deg: variance.max(0.0).sqrt(),
        mirrored: turn < 0.0,
        s_px,
        residuals_px,
    })
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;
    use rand_distr::{Distribution as _, StandardNormal};

    use super::*;

    const PLACES: [(f64, f64); 5] = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.8), (0.0, 0.8), (-0.4, 0.3)];

    /// Noses that follow moves in an image with the given directions, 2.4 µm a px.
    fn moved(x_deg: f64, z_deg: f64, noise: &mut dyn FnMut() -> f64) -> Vec<MovedNose> {
        let axis = |deg: f64| DVec2::from_angle(deg.to_radians()) / 2.4e-3;
        let of = |(x, z): (f64, f64), e: DVec2| MovedNose {
            slides_mm: DVec2::new(x, z),
            centre: DVec2::new(700.0, -600.0) + axis(x_deg) * x + axis(z_deg) * z + e,
            u_px: 0.01,
        };
        PLACES.iter().map(|p| of(*p, DVec2::new(noise(), noise()))).collect()
    }

    #[test]
    fn exact_moves_give_directions_scale_and_the_matrix_of_the_moves() {
        for (x_deg, z_deg, mirrored) in [(93.2, 3.1, false), (-90.0, 0.0, true), (181.0, 91.1, false)] {
            let places = moved(x_deg, z_deg, &mut || 0.0);
            let found = machine_axes(&places).unwrap();
            let off = |a: f64, b: f64| ((a - b + 180.0).rem_euclid(360.0) - 180.0).abs();
            assert!(off(found.x.direction_deg, x_deg) < 1e-9 && off(found.z.direction_deg, z_deg) < 1e-9);
            assert!((found.x.um_per_px - 2.4).abs() < 1e-9 && (found.z.um_per_px - 2.4).abs() < 1e-9);
            assert_eq!(found.mirrored, mirrored);
            let between = off(x_deg, z_deg);
            assert!((found.off_square_deg - (between - 90.0)).abs() < 1e-9, "{found:?}");
            // the matrix takes differences of centres back to the moves
            let d = places[2].centre - places[0].centre;
            for (row, wanted) in found.to_machine_mm_per_px.iter().zip([0.5, 0.8]) {
                assert!((row[0] * d.x + row[1] * d.y - wanted).abs() < 1e-12, "{found:?}");
            }
        }
    }

    #[test]
    fn uncertainties_hold_for_centres_with_noise() {
        let mut random = rand_pcg::Pcg64::seed_from_u64(4);
        let mut noise = || {
            let deviate: f64 = StandardNormal.sample(&mut random);
            0.01 * deviate
        };
        let mut squares = [0.0; 3];
        let draws = 2000;
        for _ in 0..draws {
            let f = machine_axes(&moved(91.0, 1.0, &mut noise)).unwrap();
            let over = [
                (f.x.direction_deg - 91.0) / f.x.u_direction_deg,
                (f.z.um_per_px - 2.4) / f.z.u_um_per_px,
                f.off_square_deg / f.u_off_square_deg,
            ];
            squares.iter_mut().zip(over).for_each(|(s, o)| *s += o * o);
        }
        for square in squares {
            // s is the larger of two, so that u is rather too large than too small
            let ratio = (square / f64::from(draws)).sqrt();
            assert!((0.8..1.05).contains(&ratio), "{ratio}");
        }
    }

    #[test]
    fn moves_that_are_too_few_on_a_line_wrong_or_diameters_are_refused() {
        let places = moved(90.0, 0.0, &mut || 0.0);
        assert_eq!(machine_axes(&places[..2]), Err(AxesError::Few(2)));
        let line: Vec<MovedNose> =
            places.iter().map(|m| MovedNose { slides_mm: DVec2::new(m.slides_mm.x, 0.01), ..*m }).collect();
        assert!(matches!(machine_axes(&line), Err(AxesError::OnALine { .. })));
        let mut wrong = places.clone();
        wrong[4].centre.x += 30.0;
        assert!(matches!(machine_axes(&wrong), Err(AxesError::Residual { number: 5, .. })));
        let diameters: Vec<MovedNose> = places
            .iter()
            .map(|m| MovedNose { slides_mm: DVec2::new(2.0 * m.slides_mm.x, m.slides_mm.y), ..*m })
            .collect();
        let said = machine_axes(&diameters).unwrap_err().to_string();
        assert!(said.contains("half of diameters"), "{said}");
    }
}
