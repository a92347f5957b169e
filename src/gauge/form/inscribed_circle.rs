//! Maximum inscribed circle (MICI, ISO 12181): the largest with no point inside, about a centre
//! within the profile.
//!
//! From the least-squares centre, the distances are replaced by their tangents r_j − u_j·d, which
//! never exceed them (the norm is convex), and the largest circle of the tangents is found by a
//! linear programme; so every step grows the circle, and near the optimum, which three points
//! determine, the error squares with each step.

use glam::DVec2;

use super::certificate::{Certificate, origin_depth};
use super::circle::{CircleFit, assemble, check, radii, touching};
use super::error::FormError;
use super::least_squares_circle::least_squares_circle;
use super::linear_program::{LinearProgram, Row};

/// Largest circle around the least-squares centre with no point inside. At least three points all
/// around.
///
/// # Errors
/// Too few, non-finite or degenerate points; an arc so short that the circle grows without bound.
pub fn maximum_inscribed_circle(points: &[DVec2]) -> Result<CircleFit, FormError> {
    let feature = "maximum inscribed circle";
    check(points, 3, feature)?;
    let start = least_squares_circle(points)?.fit;
    let origin = start.circle.centre;
    let local: Vec<DVec2> = points.iter().map(|p| *p - origin).collect();
    let reach = 0.5 * start.outer_radius;
    let mut centre = DVec2::ZERO;
    let mut box_half = reach;
    for _ in 0..100 {
        let step = best_step(&local, centre, box_half).ok_or(FormError::NotConverged { feature })?;
        if (centre + step).length() > 2.0 * reach {
            return Err(FormError::NotConverged { feature });
        }
        let grown = radii(&local, centre + step).0 > radii(&local, centre).0;
        if grown {
            centre += step;
        }
        if !grown || step.length() < 1e-15 * start.outer_radius {
            break;
        }
        box_half = box_half.min(4.0 * step.length()).max(1e-12 * reach);
    }
    let centre = origin + centre;
    Ok(assemble(points, centre, |inner, _| inner, certify_inscribed(points, centre)))
}

/// The step d that maximises min_j (r_j − u_j·d) within a box.
fn best_step(points: &[DVec2], centre: DVec2, box_half: f64) -> Option<DVec2> {
    let (inner, outer) = radii(points, centre);
    let rows: Vec<Row<3>> = points
        .iter()
        .map(|p| {
            let arm = *p - centre;
            let r = arm.length();
            let u = arm / r.max(f64::MIN_POSITIVE);
            // t = inner − radius reached: t ≥ inner − (r − u·d).
            Row { a: [-u.x, -u.y, 1.0], b: inner - r }
        })
        .collect();
    let lp = LinearProgram {
        cost: [0.0, 0.0, 1.0],
        lower: [-box_half, -box_half, -2.0 * outer],
        upper: [box_half, box_half, 2.0 * outer],
        tolerance: 1e-15 * outer,
    };
    lp.solve(&rows).map(|x| DVec2::new(x[0], x[1]))
}

/// Certifies that no centre nearby has a larger circle without points inside.
///
/// Exactly |p − c − d| ≤ r − u·d + |d|²/2r. If the hull of the contacts' directions holds a circle
/// of radius ρ about the origin, some contact has u·d ≥ ρ|d|, and the circle about c + d is smaller
/// for all |d| < 2rρ.
pub(crate) fn certify_inscribed(points: &[DVec2], centre: DVec2) -> Certificate {
    let (inner, _) = radii(points, centre);
    let near = touching(points, centre);
    let contacts: Vec<usize> =
        (0..points.len()).filter(|i| points[*i].distance(centre) <= inner + near).collect();
    let arms: Vec<DVec2> = contacts.iter().map(|i| (points[*i] - centre) / inner).collect();
    let depth = origin_depth(&arms);
    if depth <= 0.0 {
        return Certificate::none(contacts);
    }
    Certificate { contacts, gap: near, proven_within: 2.0 * inner * depth }
}
