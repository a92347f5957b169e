//! Straight lines: least squares (LSLI) and minimum zone (MZLI) after ISO 12780, distances square
//! to the line.
//!
//! The least-squares line passes through the centroid along the larger principal axis of the
//! points' scatter. The minimum zone has the least width of the convex hull: one of its borders
//! lies on a hull edge (between two such directions the width is a chord times a sine and has no
//! minimum inside), so all edges are tried.

use glam::DVec2;

use super::certificate::{Certificate, convex_hull};
use super::circle::{centroid, check};
use super::error::FormError;

/// A straight line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// A point on it.
    pub point: DVec2,
    /// Its direction, of unit length and with x ≥ 0.
    pub direction: DVec2,
}

impl Line {
    /// Signed distance of a point, positive to the left of the direction (towards +y for a line
    /// along x).
    pub(crate) fn deviation(&self, point: DVec2) -> f64 {
        self.direction.perp_dot(point - self.point)
    }

    /// Ordinate at an abscissa; infinite for a line along y.
    pub fn at(&self, x: f64) -> f64 {
        self.point.y + (x - self.point.x) * self.direction.y / self.direction.x
    }

    fn new(point: DVec2, direction: DVec2) -> Self {
        let unit = direction.normalize_or_zero();
        Self { point, direction: if unit.x < 0.0 || (unit.x == 0.0 && unit.y < 0.0) { -unit } else { unit } }
    }
}

/// A reference line with its proof.
#[derive(Clone, Debug, PartialEq)]
pub struct LineFit {
    /// The line; for a minimum zone, the middle one.
    pub line: Line,
    /// Greatest deviation to the left.
    pub highest: f64,
    /// Greatest deviation to the right, negative.
    pub lowest: f64,
    /// Proof that it is the best; `proven_within` is an angle in radians, infinite when every
    /// direction is covered.
    pub certificate: Certificate,
}

impl LineFit {
    /// Peak-to-valley deviation STRt about this line.
    pub(crate) fn peak_to_valley(&self) -> f64 {
        self.highest - self.lowest
    }
}

fn assemble(points: &[DVec2], line: Line, certificate: Certificate) -> LineFit {
    let (lowest, highest) = points
        .iter()
        .map(|p| line.deviation(*p))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), e| (low.min(e), high.max(e)));
    LineFit { line, highest, lowest, certificate }
}

/// Least-squares line of points, distances square to it. At least two points that do not coincide.
///
/// # Errors
/// Too few or non-finite points; a scatter without a longest direction.
pub fn least_squares_line(points: &[DVec2]) -> Result<LineFit, FormError> {
    let feature = "least-squares line";
    check(points, 2, feature)?;
    let mean = centroid(points);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for p in points {
        let d = *p - mean;
        xx += d.x * d.x;
        xy += d.x * d.y;
        yy += d.y * d.y;
    }
    let anisotropy = (0.5 * (xx - yy)).hypot(xy);
    let total = xx + yy;
    if total <= 0.0 || anisotropy < 1e-12 * total {
        return Err(FormError::Degenerate { feature });
    }
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    let line = Line::new(mean, DVec2::from_angle(angle));
    // The sum of squares over all directions is a cosine with one minimum; its position is rounded
    // by the scatter's relative rounding over the anisotropy.
    let span = points.iter().map(|p| p.distance(mean)).fold(0.0, f64::max);
    let gap = 4e-16 * points.len() as f64 * span * total / (2.0 * anisotropy);
    let certificate = Certificate { contacts: Vec::new(), gap, proven_within: f64::INFINITY };
    Ok(assemble(points, line, certificate))
}

/// The two parallel lines closest together that hold every point; the line returned is their
/// middle. At least two points that do not coincide.
///
/// # Errors
/// Too few, non-finite or coinciding points.
pub fn minimum_zone_line(points: &[DVec2]) -> Result<LineFit, FormError> {
    let feature = "minimum zone line";
    check(points, 2, feature)?;
    let origin = centroid(points);
    let hull = convex_hull(&points.iter().map(|p| *p - origin).collect::<Vec<_>>());
    if hull.len() < 2 {
        return Err(FormError::Degenerate { feature });
    }
    let mut best: Option<(f64, Line)> = None;
    let mut across = 1 % hull.len();
    for k in 0..hull.len() {
        let (a, b) = (hull[k], hull[(k + 1) % hull.len()]);
        let normal = (b - a).perp().normalize_or_zero();
        let height = |i: usize| normal.dot(hull[i % hull.len()] - a);
        for _ in 0..hull.len() {
            if height(across + 1) <= height(across) {
                break;
            }
            across = (across + 1) % hull.len();
        }
        let zone = height(across);
        if best.as_ref().is_none_or(|(width, _)| zone < *width) {
            best = Some((zone, Line::new(origin + a + normal * (0.5 * zone), b - a)));
        }
    }
    let (_, line) = best.ok_or(FormError::Degenerate { feature })?;
    Ok(assemble(points, line, certify_minimum_zone_line(points, line)))
}

/// Certifies that no other direction gives a narrower zone.
///
/// With contacts a, b on one border and c on the other, their feet in the order a, c, b at
/// distances s₁, s₂ along the line, turning it by δ makes the zone w·cos δ + s·|sin δ| wide at
/// least, s the one of s₁, s₂ on the turn's side: wider for all |δ| < 2·atan(min(s₁, s₂)/w). At
/// min(s₁, s₂) ≥ w that covers every direction.
pub(crate) fn certify_minimum_zone_line(points: &[DVec2], line: Line) -> Certificate {
    let zone = assemble(points, line, Certificate::default());
    let reach = points.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let near = 1e-14 * reach;
    let foot = |i: usize| line.direction.dot(points[i] - line.point);
    let touching = |value: f64| -> Vec<usize> {
        (0..points.len()).filter(|i| (line.deviation(points[*i]) - value).abs() <= near).collect()
    };
    let (above, below) = (touching(zone.highest), touching(zone.lowest));
    let span = |side: &[usize]| {
        side.iter()
            .map(|i| foot(*i))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), s| (l.min(s), h.max(s)))
    };
    let ((above_from, above_to), (below_from, below_to)) = (span(&above), span(&below));
    // Turning one way separates above_to from below_from, the other way below_to from above_from.
    let lever = (above_to - below_from).min(below_to - above_from);
    let contacts = [above, below].concat();
    if lever <= 0.0 {
        return Certificate::none(contacts);
    }
    let width = zone.peak_to_valley();
    let proven_within = if lever >= width { f64::INFINITY } else { 2.0 * (lever / width).atan() };
    Certificate { contacts, gap: 2.0 * near, proven_within }
}
