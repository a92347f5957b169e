//! A nose by its support function: how far it reaches in every direction.
//!
//! The nose is the set of points p about the tool point O. Towards a surface with the normal n(a)
//! it reaches h(a) = max(−p·n(a)), mm; concave places of the edge cut nothing, so that its convex
//! hull is all that counts. With q = −p the set {q} has the support function h itself, and q(a) =
//! h·n + h'·t is the point that touches.
//!
//! h is given at directions a_i with the tangents q·n(a_i) = h_i. A polygon of these tangents is
//! the hull's outer bound; a value that lies outside of its neighbours' tangents belongs to no body
//! and is lowered to them. On each tangent the contact is that of the circle that touches the
//! neighbouring tangents too, kept within the polygon's edge; between two contacts the hull is a
//! conic through them, tangent to both lines, with the weight cos(Δa/2) that makes it exact for a
//! circle. So the body is convex and has a tangent everywhere whatever the values are.

use glam::DVec2;
use nalgebra::DMatrix;

/// Support of the nose in a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Support {
    /// Angle a of the surface's normal, rad.
    pub a_rad: f64,
    /// h(a), mm.
    pub h_mm: f64,
    /// Standard uncertainty of h by itself, mm.
    pub u_mm: f64,
}

/// Why support values are no nose.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum NoseError {
    /// Too few directions.
    #[error("a nose needs its support in 3 directions or more, {0} are given")]
    Few(usize),
    /// A value that is no number.
    #[error("the support at {deg:.3}° is no length, or its u no uncertainty (h {h_um} µm, u {u_um} µm)")]
    Value {
        /// Direction, degrees.
        deg: f64,
        /// Support, µm.
        h_um: f64,
        /// Uncertainty, µm.
        u_um: f64,
    },
    /// Directions that are not in order or too far apart.
    #[error(
        "directions at {first_deg:.3}° and {second_deg:.3}°: neighbours must differ by more than 0 and at most \
         {most_deg}°, and all of them lie within less than a turn"
    )]
    Apart {
        /// Direction, degrees.
        first_deg: f64,
        /// The next one, degrees.
        second_deg: f64,
        /// Largest distance allowed, degrees.
        most_deg: f64,
    },
    /// A value outside of what its neighbours allow.
    #[error(
        "the support at {deg:.3}° lies {excess_um:.3} µm outside of the tangents at its neighbours: a support is that of \
         the convex hull, at most {allowed_um:.3} µm (4 u and the rounding of the file) are taken for noise"
    )]
    NoHull {
        /// Direction, degrees.
        deg: f64,
        /// Excess, µm.
        excess_um: f64,
        /// Allowed, µm.
        allowed_um: f64,
    },
    /// A covariance of another size, or none.
    #[error(
        "the covariance must be a symmetric {0} x {0} matrix, one row a direction, with no negative variance"
    )]
    Covariance(usize),
}

/// Most degrees between neighbouring directions: between them the conic keeps the support of an
/// ellipse of half axes .44 and .36 mm within 5 nm (a test measures it), and a flat that lies
/// between two directions is narrower than r/11.
const MOST_STEP_DEG: f64 = 5.0;
/// Excess over the neighbours' tangents in units of u that passes as noise: 6e-5 a direction.
const NOISE_SPREADS: f64 = 4.0;
/// Rounding of values in a file, mm: nanometres.
const ROUNDING_MM: f64 = 2e-6;

/// A nose in its reference plane.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NoseProfile {
    /// Angles of the tangents, rising, rad.
    a_rad: Vec<f64>,
    /// Support of the hull there, mm.
    h_mm: Vec<f64>,
    /// Where each tangent touches, q.
    contact: Vec<DVec2>,
    /// Corners of the polygon of tangents, between two contacts.
    corner: Vec<DVec2>,
    /// Covariance of the values, mm².
    covariance: DMatrix<f64>,
}

impl NoseProfile {
    /// A nose from its support in rising directions. `covariance_mm2` replaces the squares of u;
    /// `u_common_mm` is the uncertainty that all values share.
    ///
    /// # Errors
    /// Values that are no lengths, directions out of order or too far apart, values that belong to
    /// no convex body, a covariance of another size.
    pub(crate) fn new(
        supports: &[Support],
        covariance_mm2: Option<DMatrix<f64>>,
        u_common_mm: f64,
    ) -> Result<Self, NoseError> {
        check(supports)?;
        let n = supports.len();
        let own = covariance_mm2.unwrap_or_else(|| {
            DMatrix::from_fn(n, n, |i, j| if i == j { supports[i].u_mm.powi(2) } else { 0.0 })
        });
        let fits = own.shape() == (n, n)
            && (0..n).all(|i| own[(i, i)] >= 0.0 && (0..i).all(|j| own[(i, j)] == own[(j, i)]));
        if !fits || !own.iter().all(|v| v.is_finite()) {
            return Err(NoseError::Covariance(n));
        }
        let covariance = own.add_scalar(u_common_mm * u_common_mm);
        let a_rad: Vec<f64> = supports.iter().map(|s| s.a_rad).collect();
        let h_mm = hull(supports)?;
        let corner: Vec<DVec2> = (1..n).map(|i| corner(&a_rad, &h_mm, i - 1, i)).collect();
        let contact = (0..n).map(|i| contact(&a_rad, &h_mm, i)).collect();
        Ok(Self { a_rad, h_mm, contact, corner, covariance })
    }

    /// Least and largest direction, rad.
    pub(crate) fn range_rad(&self) -> (f64, f64) {
        (self.a_rad[0], self.a_rad[self.a_rad.len() - 1])
    }

    /// The point q(a) that touches a surface with the normal n(a); at the ends of the range, that
    /// end's.
    pub(crate) fn contact(&self, a: f64) -> DVec2 {
        let i = self.interval(a);
        let (p0, p1, p2) = (self.contact[i], self.corner[i], self.contact[i + 1]);
        let (a0, a1) = (self.a_rad[i], self.a_rad[i + 1]);
        let weight = (0.5 * (a1 - a0)).cos();
        let n = DVec2::from_angle(a.clamp(a0, a1));
        // the tangent of the conic at u is along w(1−u)²(p1−p0) + u(1−u)(p2−p0) + w·u²(p2−p1): a
        // quadratic in u/(1−u) where it is at right angles to n
        let (first, middle, last) =
            (weight * (p1 - p0).dot(n).max(0.0), (p2 - p0).dot(n), weight * (p2 - p1).dot(n).min(0.0));
        let (over, under) = (middle + (middle * middle - 4.0 * first * last).sqrt(), -2.0 * last);
        let sum = over + under;
        if sum <= 0.0 {
            return p1;
        }
        let (u, v) = (over / sum, under / sum);
        let scale = v * v + 2.0 * weight * u * v + u * u;
        (p0 * (v * v) + p1 * (2.0 * weight * u * v) + p2 * (u * u)) / scale
    }

    /// Support h(a), mm.
    pub(crate) fn support_mm(&self, a: f64) -> f64 {
        self.contact(a).dot(DVec2::from_angle(a))
    }

    /// Directions with their support, mm, `step_rad` apart at most, over its range.
    pub(crate) fn supports(&self, step_rad: f64) -> Vec<(f64, f64)> {
        let (low, high) = self.range_rad();
        let steps = ((high - low) / step_rad).ceil().max(1.0) as usize;
        let at = |k: usize| low + (high - low) * k as f64 / steps as f64;
        (0..=steps).map(|k| (at(k), self.support_mm(at(k)))).collect()
    }

    /// Points p of the nose's edge about the tool point, over its range.
    pub(crate) fn outline(&self) -> Vec<DVec2> {
        let ends = [self.contact[0], self.contact[self.contact.len() - 1]];
        ends.into_iter().chain(self.corner.iter().copied()).map(|q| -q).collect()
    }

    /// The weights by which h(a) follows from the values given: linear where the tangents turn
    /// about one point.
    pub(crate) fn weights(&self, a: f64) -> [(usize, f64); 2] {
        let i = self.interval(a);
        let (a0, a1) = (self.a_rad[i], self.a_rad[i + 1]);
        let (a, whole) = (a.clamp(a0, a1), (a1 - a0).sin());
        [(i, (a1 - a).sin() / whole), (i + 1, (a - a0).sin() / whole)]
    }

    /// Standard uncertainty of the sum of values times `weights`, mm.
    pub(crate) fn u_of(&self, weights: &[(usize, f64)]) -> f64 {
        let sum: f64 = weights
            .iter()
            .flat_map(|&(i, g)| weights.iter().map(move |&(j, k)| g * k * self.covariance[(i, j)]))
            .sum();
        sum.max(0.0).sqrt()
    }

    fn interval(&self, a: f64) -> usize {
        self.a_rad.partition_point(|&x| x <= a).clamp(1, self.a_rad.len() - 1) - 1
    }
}

fn check(supports: &[Support]) -> Result<(), NoseError> {
    if supports.len() < 3 {
        return Err(NoseError::Few(supports.len()));
    }
    for s in supports {
        if !(s.a_rad.is_finite() && s.h_mm.is_finite() && s.u_mm.is_finite() && s.u_mm >= 0.0) {
            let (h_um, u_um) = (1e3 * s.h_mm, 1e3 * s.u_mm);
            return Err(NoseError::Value { deg: s.a_rad.to_degrees(), h_um, u_um });
        }
    }
    let apart = |first: f64, second: f64| NoseError::Apart {
        first_deg: first.to_degrees(),
        second_deg: second.to_degrees(),
        most_deg: MOST_STEP_DEG,
    };
    for pair in supports.windows(2) {
        let step = (pair[1].a_rad - pair[0].a_rad).to_degrees();
        if !(step > 1e-6 && step <= MOST_STEP_DEG + 1e-9) {
            return Err(apart(pair[0].a_rad, pair[1].a_rad));
        }
    }
    let (first, last) = (supports[0].a_rad, supports[supports.len() - 1].a_rad);
    if last - first >= std::f64::consts::TAU {
        return Err(apart(first, last));
    }
    Ok(())
}

/// Support at `a` of the corner of two tangents.
fn of_corner((a0, h0): (f64, f64), (a1, h1): (f64, f64), a: f64) -> f64 {
    (h0 * (a1 - a).sin() + h1 * (a - a0).sin()) / (a1 - a0).sin()
}

/// The values as the support of a convex body: each at most that of its neighbours' corner.
fn hull(supports: &[Support]) -> Result<Vec<f64>, NoseError> {
    let mut kept: Vec<usize> = Vec::with_capacity(supports.len());
    let at = |i: usize| (supports[i].a_rad, supports[i].h_mm);
    for next in 0..supports.len() {
        while let [.., before, last] = kept[..] {
            let wide = supports[next].a_rad - supports[before].a_rad >= std::f64::consts::FRAC_PI_2;
            if wide || supports[last].h_mm <= of_corner(at(before), at(next), supports[last].a_rad) {
                break;
            }
            kept.pop();
        }
        kept.push(next);
    }
    let mut h: Vec<f64> = supports.iter().map(|s| s.h_mm).collect();
    for pair in kept.windows(2) {
        for i in pair[0] + 1..pair[1] {
            h[i] = of_corner(at(pair[0]), at(pair[1]), supports[i].a_rad);
            let (excess, allowed) = (supports[i].h_mm - h[i], NOISE_SPREADS * supports[i].u_mm + ROUNDING_MM);
            if excess > allowed {
                return Err(NoseError::NoHull {
                    deg: supports[i].a_rad.to_degrees(),
                    excess_um: 1e3 * excess,
                    allowed_um: 1e3 * allowed,
                });
            }
        }
    }
    Ok(h)
}

/// Where two tangents intersect.
fn corner(a: &[f64], h: &[f64], i: usize, j: usize) -> DVec2 {
    let n = DVec2::from_angle(a[i]);
    let turn = a[j] - a[i];
    n * h[i] + n.perp() * ((h[j] - h[i] * turn.cos()) / turn.sin())
}

/// Where tangent `i` touches: as the circle that touches the two next to it, within its edge.
fn contact(a: &[f64], h: &[f64], i: usize) -> DVec2 {
    let last = a.len() - 1;
    let middle = i.clamp(1, last - 1);
    let n = DVec2::from_angle(a[i]);
    // h = A + B·cos δ + C·sin δ about the middle of three tangents; A is the circle's radius
    let row = |j: usize| {
        let d = a[j] - a[middle];
        (d.cos() - 1.0, d.sin(), h[j] - h[middle])
    };
    let ((b0, c0, y0), (b1, c1, y1)) = (row(middle - 1), row(middle + 1));
    let det = b0 * c1 - b1 * c0;
    let (b, c) = ((y0 * c1 - y1 * c0) / det, (b0 * y1 - b1 * y0) / det);
    let d = a[i] - a[middle];
    let slope = -b * d.sin() + c * d.cos();
    let edge = |j: usize| {
        let turn = a[j] - a[i];
        (h[j] - h[i] * turn.cos()) / turn.sin()
    };
    let low = if i > 0 { edge(i - 1) } else { f64::NEG_INFINITY };
    let high = if i < last { edge(i + 1) } else { f64::INFINITY };
    // rounding may leave an edge of negative length where three tangents meet in a point
    let along = if low < high { slope.clamp(low, high) } else { 0.5 * (low + high) };
    n * h[i] + n.perp() * along
}
