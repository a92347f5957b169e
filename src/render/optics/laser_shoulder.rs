//! Shoulders in laser light: the amplitudes of the half planes multiply.
//!
//! Behind an outline of level pieces e_j between the columns c_j, the amplitude of a monochromatic
//! point source is
//!
//! ```text
//! U(x, y) = Σ_j [H(x - c_j) - H(x - c_{j+1})] · H(e_j - y),   I = |U|²
//! H(v) = ((½ + C) + i(½ + S))·(1 - i)/2
//! ```
//!
//! exactly (Kirchhoff's integral separates). The average over line, source and pixel is taken from
//! the straight edges' own table F, where it is accurate, and by three nodes each for the
//! contribution of the corner:
//!
//! ```text
//! I = Σ_j p_j F(e_j - y) + ⟨|U|² - Σ_j p_j |H(e_j - y)|²⟩,   p_j(x) a soft partition of columns
//! ```

use std::sync::LazyLock;

use super::edge_spread::LaserShadow;
use super::edge_spread::fresnel_integrals::fresnel;
use super::edge_spread::gaussian::gaussian;
use super::esf_table::{EsfTable, TablePlace};

/// Distance from a shoulder, in √(λz/2), up to which columns are affected by it: its rings have 2 %
/// of the amplitude there.
pub(crate) const SEEN_UNITS: f64 = 10.0;

/// Distance, in √(λz/2), beyond which shoulders are neglected.
const FAR_UNITS: f64 = 30.0;

/// Width of the soft partition, √(λz/2).
const SOFT_UNITS: f64 = 0.25;

/// Full width at half maximum over the standard deviation of a Gaussian line.
const FWHM: f64 = 2.354_820_045;

/// Knots per unit of the table of H, and its reach; linear interpolation errs by (1/512)²/8·120 =
/// 6e-5 at its end.
const KNOTS: f64 = 512.0;
const REACH: f64 = 40.0;

type Complex = (f64, f64);

static HALF_PLANE: LazyLock<Vec<Complex>> = LazyLock::new(|| {
    let knot = |i: usize| {
        let (c, s) = fresnel(i as f64 / KNOTS - REACH);
        (0.5 * (1.0 + c + s), 0.5 * (s - c))
    };
    (0..=(2.0 * REACH * KNOTS) as usize + 1).map(knot).collect()
});

/// H: share of the amplitude at v into the light of a half plane.
fn half_plane(v: f64) -> Complex {
    if v.abs() >= REACH {
        return (if v > 0.0 { 1.0 } else { 0.0 }, 0.0);
    }
    let place = (v + REACH) * KNOTS;
    let (a, b) = (HALF_PLANE[place as usize], HALF_PLANE[place as usize + 1]);
    let t = place.fract();
    (a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1))
}

/// Three nodes of a distribution of standard deviation `sd` about 0.
fn three(sd: f64) -> [(f64, f64); 3] {
    let away = 3f64.sqrt() * sd;
    [(-away, 1.0 / 6.0), (0.0, 2.0 / 3.0), (away, 1.0 / 6.0)]
}

/// A laser in front of a stepped outline.
pub(crate) struct LaserShoulder {
    /// √(λz/2), px.
    unit_px: f64,
    /// √(λ0/λ) and weight.
    line: [(f64, f64); 3],
    /// Shifts along one axis by pixel and source, px.
    shifts: [(f64, f64); 3],
}

/// One edge of the outline about a column: level pieces between corners.
pub(crate) struct Pieces {
    /// Columns of the corners, ascending.
    pub corners: Vec<f64>,
    /// Row of each piece, one more than there are corners.
    pub rows: Vec<f64>,
    /// 1 where the light lies above, -1 below.
    pub sign: f64,
}

/// Rows of one column to which light is added.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rows {
    /// The column.
    pub(crate) at: f64,
    /// The first row.
    pub(crate) first: f64,
    /// Share of the exposure.
    pub(crate) weight: f64,
}

impl LaserShoulder {
    pub(crate) fn new(laser: &LaserShadow, pixel_um: f64, scale: f64) -> Self {
        let relative = laser.bandwidth_nm / FWHM / laser.wavelength_nm;
        let source_px = laser.source_half_angle_mrad * laser.distance_mm / pixel_um;
        Self {
            unit_px: laser.unit_um() / pixel_um * scale,
            line: three(relative).map(|(u, w)| ((1.0 / (1.0 + u)).sqrt(), w)),
            shifts: three((1.0 / 12.0 + 0.25 * source_px * source_px).sqrt()),
        }
    }

    /// Range of columns about `at` whose corners are included.
    pub(crate) fn about(&self, at: f64) -> (f64, f64) {
        (at - FAR_UNITS * self.unit_px, at + FAR_UNITS * self.unit_px)
    }

    /// Rows of the pieces that affect a column.
    pub(crate) fn rows_seen(&self, pieces: &Pieces, at: f64) -> impl Iterator<Item = f64> {
        let reach = SEEN_UNITS * self.unit_px;
        let begins = std::iter::once(f64::NEG_INFINITY).chain(pieces.corners.iter().copied());
        let ends = pieces.corners.iter().copied().chain([f64::INFINITY]);
        let near = begins.zip(ends).map(move |(begin, end)| begin <= at + reach && end >= at - reach);
        near.zip(&pieces.rows).filter(|(near, _)| *near).map(|(_, row)| *row)
    }

    /// Adds weight·I of the rows of a column.
    pub(crate) fn add(
        &self,
        pieces: &Pieces,
        (esf, place): (&EsfTable, &TablePlace),
        Rows { at, first, weight }: Rows,
        light: &mut [f64],
    ) {
        let count = pieces.rows.len();
        let steps = |before: f64, f: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let inner = pieces.corners.iter().map(|c| f(at - c));
            let ends: Vec<f64> = std::iter::once(before).chain(inner).chain([0.0]).collect();
            ends.windows(2).map(|e| e[0] - e[1]).collect()
        };
        let soft = steps(1.0, &|d| gaussian(d / (SOFT_UNITS * self.unit_px)).0);
        let mut across = Vec::with_capacity(9 * count);
        for (scale, line) in self.line {
            for (dx, share) in self.shifts {
                let v = |d: f64| (d + dx) / self.unit_px * scale;
                let (re, im) = (steps(1.0, &|d| half_plane(v(d)).0), steps(0.0, &|d| half_plane(v(d)).1));
                across.push((scale, line * share, re.into_iter().zip(im).collect::<Vec<Complex>>()));
            }
        }
        for (r, light) in light.iter_mut().enumerate() {
            let into = |j: usize| pieces.sign * (pieces.rows[j] - first - r as f64);
            let straight: f64 = (0..count).map(|j| soft[j] * esf.sample(place, into(j))).sum();
            let mut corner = 0.0;
            for (scale, share, weights) in &across {
                for (dy, down) in self.shifts {
                    let (mut u, mut alone) = ((0.0, 0.0), 0.0);
                    for (j, h) in weights.iter().enumerate() {
                        let a = half_plane((into(j) + dy) / self.unit_px * scale);
                        u = (u.0 + h.0 * a.0 - h.1 * a.1, u.1 + h.0 * a.1 + h.1 * a.0);
                        alone += soft[j] * (a.0 * a.0 + a.1 * a.1);
                    }
                    corner += share * down * (u.0 * u.0 + u.1 * u.1 - alone);
                }
            }
            *light += weight * (straight + corner);
        }
    }
}
