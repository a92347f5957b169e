//! Minimum circumscribed circle (MCCI, ISO 12181): the smallest that holds every point.
//!
//! Exchange: the smallest circle of at most three support points; the farthest point outside
//! enters; the radius grows with every exchange, so that it ends at the exact optimum. The problem
//! is convex: a circle that holds all points and whose centre lies in the convex hull of the points
//! it touches is the smallest, everywhere.

use glam::DVec2;

use super::certificate::Certificate;
use super::circle::{Circle, CircleFit, assemble, check, radii, touching};
use super::error::FormError;

/// Smallest circle that holds every point. At least two points.
///
/// # Errors
/// Too few, non-finite or coinciding points.
pub fn minimum_circumscribed_circle(points: &[DVec2]) -> Result<CircleFit, FormError> {
    let feature = "minimum circumscribed circle";
    check(points, 2, feature)?;
    let origin = super::circle::centroid(points);
    let local: Vec<DVec2> = points.iter().map(|p| *p - origin).collect();
    let farthest = |from: DVec2| {
        local.iter().copied().max_by(|a, b| a.distance_squared(from).total_cmp(&b.distance_squared(from)))
    };
    let degenerate = FormError::Degenerate { feature };
    let first = farthest(DVec2::ZERO).ok_or_else(|| degenerate.clone())?;
    let second = farthest(first).ok_or_else(|| degenerate.clone())?;
    let mut support = vec![first, second];
    let mut circle = smallest_of(&support).ok_or_else(|| degenerate.clone())?.0;
    if circle.radius <= 0.0 {
        return Err(degenerate);
    }
    for _ in 0..10_000 {
        let Some(out) = farthest(circle.centre) else { break };
        if circle.deviation(out) <= 2e-15 * circle.radius {
            let centre = origin + circle.centre;
            return Ok(assemble(points, centre, |_, outer| outer, certify_circumscribed(points, centre)));
        }
        support.push(out);
        let before = circle.radius;
        (circle, support) = smallest_of(&support).ok_or_else(|| degenerate.clone())?;
        if circle.radius <= before {
            let centre = origin + circle.centre;
            return Ok(assemble(points, centre, |_, outer| outer, certify_circumscribed(points, centre)));
        }
    }
    Err(FormError::NotConverged { feature })
}

/// Smallest circle of up to four points by trying every pair and triple.
fn smallest_of(points: &[DVec2]) -> Option<(Circle, Vec<DVec2>)> {
    let mut best: Option<(Circle, Vec<DVec2>)> = None;
    let mut offer = |circle: Circle, support: Vec<DVec2>| {
        let holds = points.iter().all(|p| circle.deviation(*p) <= 1e-14 * circle.radius);
        if holds && best.as_ref().is_none_or(|(b, _)| circle.radius < b.radius) {
            best = Some((circle, support));
        }
    };
    for (i, a) in points.iter().enumerate() {
        for (j, b) in points.iter().enumerate().skip(i + 1) {
            let centre = a.midpoint(*b);
            offer(Circle { centre, radius: a.distance(centre).max(b.distance(centre)) }, vec![*a, *b]);
            for c in points.iter().skip(j + 1) {
                if let Some(circle) = through(*a, *b, *c) {
                    offer(circle, vec![*a, *b, *c]);
                }
            }
        }
    }
    best
}

/// The circle through three points, `None` if they lie on a line.
pub(super) fn through(a: DVec2, b: DVec2, c: DVec2) -> Option<Circle> {
    let (p, q) = (b - a, c - a);
    let area = 2.0 * p.perp_dot(q);
    if area.abs() < 1e-14 * p.length() * q.length() {
        return None;
    }
    let u = DVec2::new(
        q.y * p.length_squared() - p.y * q.length_squared(),
        p.x * q.length_squared() - q.x * p.length_squared(),
    ) / area;
    let centre = a + u;
    Some(Circle { centre, radius: a.distance(centre).max(b.distance(centre)).max(c.distance(centre)) })
}

/// Certifies that no circle with another centre is smaller.
///
/// With contacts p_i at distance R, and some Σλ_i(p_i − c) = 0 (λ ≥ 0), every centre c + d has a
/// contact at distance √(R² + |d|²) or more. If the nearest point of the contacts' hull lies ε from
/// c, the gain is at most ε.
pub(crate) fn certify_circumscribed(points: &[DVec2], centre: DVec2) -> Certificate {
    let (_, outer) = radii(points, centre);
    let near = touching(points, centre);
    let contacts: Vec<usize> =
        (0..points.len()).filter(|i| points[*i].distance(centre) >= outer - near).collect();
    let arms: Vec<DVec2> = contacts.iter().map(|i| points[*i] - centre).collect();
    let miss = distance_to_hull(&arms);
    if miss > 1e-9 * outer {
        return Certificate::none(contacts);
    }
    Certificate { contacts, gap: near + miss, proven_within: f64::INFINITY }
}

/// Distance of the origin from the convex hull of vectors.
fn distance_to_hull(vectors: &[DVec2]) -> f64 {
    if super::certificate::origin_depth(vectors) > 0.0 {
        return 0.0;
    }
    let to_segment = |a: DVec2, b: DVec2| {
        let along = b - a;
        let t = (-a.dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (a + along * t).length()
    };
    let hull = super::certificate::convex_hull(vectors);
    (0..hull.len()).map(|k| to_segment(hull[k], hull[(k + 1) % hull.len()])).fold(f64::INFINITY, f64::min)
}
