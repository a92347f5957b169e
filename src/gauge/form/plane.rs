//! Planes: least squares (LSPL) and minimum zone (MZPL) after ISO 12781, distances square to the
//! plane.
//!
//! The least-squares plane passes through the centroid across the smallest principal axis of the
//! scatter. In its frame every point has a height over two coordinates; the minimum zone is the
//! Chebyshev plane of the heights, a linear programme in offset, two slopes and half the width,
//! solved by exchange and, in the frame of what was found, once more: there the slopes are zero,
//! and vertical distances are distances square to the plane.

use glam::{DVec2, DVec3};
use nalgebra::Matrix3;

use super::certificate::{Certificate, origin_depth};
use super::error::FormError;
use super::linear_program::{LinearProgram, Row};

/// A plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plane {
    /// A point on it.
    pub(crate) point: DVec3,
    /// Its normal, of unit length and with z ≥ 0.
    pub(crate) normal: DVec3,
}

impl Plane {
    /// Signed distance of a point, positive on the normal's side.
    pub(crate) fn deviation(&self, point: DVec3) -> f64 {
        self.normal.dot(point - self.point)
    }

    fn new(point: DVec3, normal: DVec3) -> Self {
        let unit = normal.normalize_or_zero();
        Self { point, normal: if unit.z < 0.0 { -unit } else { unit } }
    }

    /// Two directions in the plane, square to each other.
    fn axes(&self) -> (DVec3, DVec3) {
        self.normal.any_orthonormal_pair()
    }

    /// A point's coordinates in the plane, and its height.
    fn local(&self, axes: (DVec3, DVec3), point: DVec3) -> (DVec2, f64) {
        let from = point - self.point;
        (DVec2::new(axes.0.dot(from), axes.1.dot(from)), self.normal.dot(from))
    }
}

/// A reference plane with its proof.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlaneFit {
    /// The plane; for a minimum zone, the middle one.
    pub(crate) plane: Plane,
    /// Greatest deviation on the normal's side.
    pub(crate) highest: f64,
    /// Greatest deviation on the other, negative.
    pub(crate) lowest: f64,
    /// Proof that it is the best; `proven_within` is an angle in radians, infinite when every
    /// direction is covered.
    pub(crate) certificate: Certificate,
}

impl PlaneFit {
    /// Peak-to-valley deviation FLTt about this plane.
    pub(crate) fn peak_to_valley(&self) -> f64 {
        self.highest - self.lowest
    }
}

fn assemble(points: &[DVec3], plane: Plane, certificate: Certificate) -> PlaneFit {
    let (lowest, highest) = points
        .iter()
        .map(|p| plane.deviation(*p))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), e| (low.min(e), high.max(e)));
    PlaneFit { plane, highest, lowest, certificate }
}

fn check(points: &[DVec3], feature: &'static str) -> Result<(), FormError> {
    if points.len() < 3 {
        return Err(FormError::TooFew { feature, found: points.len(), needed: 3 });
    }
    points.iter().position(|p| !p.is_finite()).map_or(Ok(()), |index| Err(FormError::NotFinite { index }))
}

/// Least-squares plane of points, distances square to it. At least three points that lie on no
/// straight line.
///
/// # Errors
/// Too few or non-finite points; a scatter without a smallest direction.
pub(crate) fn least_squares_plane(points: &[DVec3]) -> Result<PlaneFit, FormError> {
    let feature = "least-squares plane";
    check(points, feature)?;
    let mean = points.iter().copied().sum::<DVec3>() / points.len() as f64;
    let mut scatter = Matrix3::zeros();
    for p in points {
        let d = nalgebra::Vector3::from((*p - mean).to_array());
        scatter += d * d.transpose();
    }
    let eigen = scatter.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    let [least, middle, most] = order.map(|k| eigen.eigenvalues[k]);
    if most <= 0.0 || middle - least < 1e-12 * most {
        return Err(FormError::Degenerate { feature });
    }
    let normal = eigen.eigenvectors.column(order[0]);
    let plane = refine(points, Plane::new(mean, DVec3::new(normal[0], normal[1], normal[2])));
    // The sum of squares has one minimum over the directions; rounding of the scatter moves it.
    let span = points.iter().map(|p| p.distance(mean)).fold(0.0, f64::max);
    let gap = 4e-16 * points.len() as f64 * span;
    let certificate = Certificate { contacts: Vec::new(), gap, proven_within: f64::INFINITY };
    Ok(assemble(points, plane, certificate))
}

/// One step of least squares over the heights in a plane's frame: what the rounding of the large
/// eigenvalues left of the normal's direction.
fn refine(points: &[DVec3], plane: Plane) -> Plane {
    let axes = plane.axes();
    let (mut normal, mut right) = (Matrix3::zeros(), nalgebra::Vector3::zeros());
    for p in points {
        let (at, height) = plane.local(axes, *p);
        let row = nalgebra::Vector3::new(1.0, at.x, at.y);
        normal += row * row.transpose();
        right += row * height;
    }
    normal.cholesky().map_or(plane, |c| tilted(&plane, axes, c.solve(&right).into()))
}

/// The plane of heights o + a·x + b·y in a plane's frame.
fn tilted(plane: &Plane, (u, v): (DVec3, DVec3), [o, a, b]: [f64; 3]) -> Plane {
    Plane::new(plane.point + plane.normal * o, plane.normal - u * a - v * b)
}

/// The two parallel planes closest together that hold every point; the plane returned is their
/// middle. At least three points that lie on no straight line.
///
/// # Errors
/// As [`least_squares_plane`]; rounding that defeats the linear programme.
pub(crate) fn minimum_zone_plane(points: &[DVec3]) -> Result<PlaneFit, FormError> {
    let feature = "minimum zone plane";
    let start = least_squares_plane(points).map_err(|e| match e {
        FormError::Degenerate { .. } => FormError::Degenerate { feature },
        other => other,
    })?;
    let mut plane = start.plane;
    let mut bound = 4.0 * start.peak_to_valley();
    let reach = points.iter().map(|p| p.distance(plane.point)).fold(0.0, f64::max);
    if bound <= 1e-15 * reach {
        return Ok(assemble(points, plane, certify_minimum_zone_plane(points, plane)));
    }
    // In a shrinking box about what was found, so that the programme's tie-breaking cost vanishes.
    for _ in 0..3 {
        let axes = plane.axes();
        let [o, a, b, _] =
            chebyshev(points, &plane, reach, bound).ok_or(FormError::NotConverged { feature })?;
        plane = tilted(&plane, axes, [o, a / reach, b / reach]);
        bound = (1e-3 * bound).max(1e-14 * reach);
    }
    Ok(assemble(points, plane, certify_minimum_zone_plane(points, plane)))
}

/// Offset, slopes over the reach and half width of the Chebyshev plane in a plane's frame. The half
/// width counts from the one of the frame, so that all unknowns are small steps.
fn chebyshev(points: &[DVec3], plane: &Plane, reach: f64, bound: f64) -> Option<[f64; 4]> {
    let axes = plane.axes();
    let heights = points.iter().map(|p| plane.local(axes, *p));
    let widest = heights.clone().map(|(_, h)| h.abs()).fold(0.0, f64::max);
    let mut rows = Vec::with_capacity(2 * points.len());
    for (at, height) in heights {
        let [x, y] = (at / reach).to_array();
        rows.push(Row { a: [1.0, x, y, 1.0], b: height - widest });
        rows.push(Row { a: [-1.0, -x, -y, 1.0], b: -height - widest });
    }
    let lp = LinearProgram {
        cost: [0.0, 0.0, 0.0, 1.0],
        lower: [-bound; 4],
        upper: [bound; 4],
        tolerance: 1e-15 * reach,
    };
    lp.solve(&rows)
}

/// Certifies that no other direction gives a narrower zone.
///
/// With U and L the feet of the contacts on the upper and the lower border, turning the plane by δ
/// towards a direction n makes the zone W·cos δ + n·(U − L)·sin δ wide at least, for any pair. In
/// every direction some pair reaches ρ, the depth of the origin in the hull of all U − L: wider for
/// all δ < 2·atan(ρ/W), and everywhere at ρ ≥ W.
pub(crate) fn certify_minimum_zone_plane(points: &[DVec3], plane: Plane) -> Certificate {
    let zone = assemble(points, plane, Certificate::default());
    let reach = points.iter().map(|p| p.distance(plane.point)).fold(0.0, f64::max)
        + points.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let near = 2e-14 * reach;
    let axes = plane.axes();
    let touching = |value: f64| -> Vec<usize> {
        (0..points.len()).filter(|i| (plane.deviation(points[*i]) - value).abs() <= near).collect()
    };
    let (above, below) = (touching(zone.highest), touching(zone.lowest));
    let foot = |i: &usize| plane.local(axes, points[*i]).0;
    let pairs: Vec<DVec2> = above.iter().flat_map(|i| below.iter().map(move |j| foot(i) - foot(j))).collect();
    let (depth, width) = (origin_depth(&pairs), zone.peak_to_valley());
    let contacts = [above, below].concat();
    if depth <= 0.0 {
        return Certificate::none(contacts);
    }
    let proven_within = if depth >= width { f64::INFINITY } else { 2.0 * (depth / width).atan() };
    Certificate { contacts, gap: 2.0 * near, proven_within }
}
