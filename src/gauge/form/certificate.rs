//! Proof that a feature is the best one.

use glam::DVec2;

/// Proof of optimality of a reference feature.
///
/// The claim: no feature whose centre lies within `proven_within` of the one given has an objective
/// better by more than `gap`. It is derived from first-order conditions and exact bounds of the
/// second order, which are given where each certificate is computed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Certificate {
    /// Indices of the points that determine the feature (touch it within `gap`).
    pub contacts: Vec<usize>,
    /// By how much the objective could still be improved, in the points' unit.
    pub gap: f64,
    /// Radius around the centre in which the optimum is proven; infinite for a global proof, 0 for
    /// none.
    pub proven_within: f64,
}

impl Certificate {
    /// A certificate without a proof.
    pub(crate) fn none(contacts: Vec<usize>) -> Self {
        Self { contacts, gap: f64::INFINITY, proven_within: 0.0 }
    }

    /// Whether the feature is proven best, in a neighbourhood at least.
    #[cfg(test)]
    pub(crate) fn is_proven(&self) -> bool {
        self.proven_within > 0.0 && self.gap.is_finite()
    }
}

/// Radius of the largest circle about the origin inside the convex hull of `vectors`; 0 if the
/// origin is not inside.
///
/// By directions: the hull contains that circle exactly if in every direction some vector reaches
/// at least ρ; the least reach is attained at a normal of a hull edge.
pub(crate) fn origin_depth(vectors: &[DVec2]) -> f64 {
    let hull = convex_hull(vectors);
    if hull.len() < 3 {
        return 0.0;
    }
    let depth = (0..hull.len())
        .map(|k| {
            let (a, b) = (hull[k], hull[(k + 1) % hull.len()]);
            // Counter-clockwise hull: the outward normal's distance to the origin is the cross
            // product over the length.
            a.perp_dot(b) / (b - a).length().max(f64::MIN_POSITIVE)
        })
        .fold(f64::INFINITY, f64::min);
    depth.max(0.0)
}

/// Convex hull, counter-clockwise, without collinear points (Andrew's monotone chain).
pub(crate) fn convex_hull(points: &[DVec2]) -> Vec<DVec2> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let mut hull: Vec<DVec2> = Vec::with_capacity(sorted.len() + 1);
    let half = |hull: &mut Vec<DVec2>, p: DVec2, floor: usize| {
        while hull.len() > floor
            && (hull[hull.len() - 1] - hull[hull.len() - 2]).perp_dot(p - hull[hull.len() - 2]) <= 0.0
        {
            hull.pop();
        }
        hull.push(p);
    };
    for p in &sorted {
        half(&mut hull, *p, 1);
    }
    let floor = hull.len();
    for p in sorted.iter().rev().skip(1) {
        half(&mut hull, *p, floor);
    }
    hull.pop();
    hull
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_of_a_square_is_its_inradius_and_zero_outside() {
        let square = [DVec2::new(1., 1.), DVec2::new(-1., 1.), DVec2::new(-1., -1.), DVec2::new(1., -1.)];
        assert!((origin_depth(&square) - 1.0).abs() < 1e-15);
        let away: Vec<DVec2> = square.iter().map(|v| *v + DVec2::new(1.5, 0.0)).collect();
        assert_eq!(origin_depth(&away), 0.0);
        assert_eq!(origin_depth(&square[..2]), 0.0);
    }
}
