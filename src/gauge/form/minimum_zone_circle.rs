//! Minimum zone circles (MZCI, ISO 12181): the two concentric circles closest together that hold
//! every point.
//!
//! Minimise F(c) = max_i r_i − min_j r_j. Linearised about a centre, that is the Chebyshev
//! approximation of the distances by m + u·d, a linear programme; its steps converge quadratically,
//! because the optimum is a vertex: two points outside and two inside, alternating. A step is taken
//! only if it narrows the zone.

use glam::DVec2;

use super::certificate::{Certificate, origin_depth};
use super::circle::{CircleFit, assemble, check, radii, touching};
use super::error::FormError;
use super::least_squares_circle::least_squares_circle;
use super::linear_program::{LinearProgram, Row};

/// The pair of concentric circles with the least distance; the circle returned is their mean. At
/// least four points all around.
///
/// # Errors
/// Too few, non-finite or degenerate points.
pub fn minimum_zone_circle(points: &[DVec2]) -> Result<CircleFit, FormError> {
    let feature = "minimum zone circle";
    check(points, 4, feature)?;
    let start = least_squares_circle(points)?.fit;
    let origin = start.circle.centre;
    let local: Vec<DVec2> = points.iter().map(|p| *p - origin).collect();
    let mut centre = DVec2::ZERO;
    let mut box_half = (2.0 * start.peak_to_valley()).min(0.5 * start.inner_radius);
    let smallest = 1e-15 * start.outer_radius;
    for _ in 0..200 {
        if box_half < smallest {
            break;
        }
        let step = best_step(&local, centre, box_half).ok_or(FormError::NotConverged { feature })?;
        if width(&local, centre + step) < width(&local, centre) {
            centre += step;
            box_half = (2.0 * step.length()).max(smallest).min(box_half);
        } else {
            box_half = 0.25 * box_half.min(step.length());
        }
    }
    let centre = origin + centre;
    let certificate = certify_minimum_zone(points, centre);
    Ok(assemble(points, centre, |inner, outer| 0.5 * (inner + outer), certificate))
}

fn width(points: &[DVec2], centre: DVec2) -> f64 {
    let (inner, outer) = radii(points, centre);
    outer - inner
}

/// The step d that minimises max_i (r_i − u_i·d) − min_j (r_j − u_j·d) within a box.
fn best_step(points: &[DVec2], centre: DVec2, box_half: f64) -> Option<DVec2> {
    let (inner, outer) = radii(points, centre);
    let mean = 0.5 * (inner + outer);
    let mut rows: Vec<Row<4>> = Vec::with_capacity(2 * points.len());
    for p in points {
        let arm = *p - centre;
        let r = arm.length();
        let u = arm / r.max(f64::MIN_POSITIVE);
        rows.push(Row { a: [u.x, u.y, 1.0, 1.0], b: r - mean });
        rows.push(Row { a: [-u.x, -u.y, -1.0, 1.0], b: mean - r });
    }
    let reach = 2.0 * (box_half + outer - inner) + 1e-12 * outer;
    let lp = LinearProgram {
        cost: [0.0, 0.0, 0.0, 1.0],
        lower: [-box_half, -box_half, -reach, 0.0],
        upper: [box_half, box_half, reach, 2.0 * reach],
        tolerance: 1e-15 * outer,
    };
    lp.solve(&rows).map(|x| DVec2::new(x[0], x[1]))
}

/// Certifies that no centre nearby has a narrower zone.
///
/// Exactly |p − c − d| ≥ r − u·d for the outer contacts and ≤ r − u·d + |d|²/2r for the inner ones.
/// If the hull of the differences u_inner − u_outer holds a circle of radius ρ about the origin,
/// the zone about c + d is wider for all |d| < 2·r_inner·ρ.
pub(crate) fn certify_minimum_zone(points: &[DVec2], centre: DVec2) -> Certificate {
    let (inner, outer) = radii(points, centre);
    let near = touching(points, centre);
    let mut contacts = Vec::new();
    let (mut outside, mut inside) = (Vec::new(), Vec::new());
    for (i, p) in points.iter().enumerate() {
        let r = p.distance(centre);
        let u = (*p - centre) / r.max(f64::MIN_POSITIVE);
        if r >= outer - near {
            outside.push(u);
        }
        if r <= inner + near {
            inside.push(u);
        }
        if r >= outer - near || r <= inner + near {
            contacts.push(i);
        }
    }
    // Of very many contacts (a perfect circle) a spread of them is proof enough.
    let thin = |v: &[DVec2]| v.iter().step_by(1 + v.len() / 64).copied().collect::<Vec<_>>();
    let (outside, inside) = (thin(&outside), thin(&inside));
    let differences: Vec<DVec2> = outside.iter().flat_map(|o| inside.iter().map(move |i| *i - *o)).collect();
    let depth = origin_depth(&differences);
    if depth <= 0.0 {
        return Certificate::none(contacts);
    }
    Certificate { contacts, gap: 2.0 * near, proven_within: 2.0 * inner * depth }
}
