//! Convex outlines in the plane of the tool, (Z, radius), and whether a moving one meets one at
//! rest.
//!
//! A convex outline that moves straight from a to b sweeps the convex hull of its two end
//! positions. Two convex outlines are disjoint if and only if the normal of one of their edges
//! separates them (Ericson, Real-Time Collision Detection, Morgan Kaufmann 2005, 5.2.1).

/// Overlap up to which outlines merely touch, mm: above rounding, far below a control's increment.
const TOUCH_MM: f64 = 1e-7;

/// A convex polygon, anticlockwise.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Convex {
    points: Vec<(f64, f64)>,
}

impl Convex {
    /// The convex hull of points (Z, radius), mm (Andrew's monotone chain).
    pub(crate) fn hull(mut points: Vec<(f64, f64)>) -> Self {
        points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        points.dedup();
        if points.len() < 3 {
            return Self { points };
        }
        let half = |ordered: &mut dyn Iterator<Item = &(f64, f64)>| {
            let mut chain: Vec<(f64, f64)> = Vec::new();
            for &p in ordered {
                while let [.., a, b] = chain[..] {
                    if cross(a, b, p) > 0.0 {
                        break;
                    }
                    chain.pop();
                }
                chain.push(p);
            }
            chain.pop();
            chain
        };
        let mut chain = half(&mut points.iter());
        chain.extend(half(&mut points.iter().rev()));
        Self { points: chain }
    }

    /// A rectangle from the axis: `from_z` to `to_z`, up to `diameter` mm.
    pub(crate) fn cylinder(from_z: f64, to_z: f64, diameter: f64) -> Self {
        let r = 0.5 * diameter;
        Self { points: vec![(from_z, 0.0), (to_z, 0.0), (to_z, r), (from_z, r)] }
    }

    /// From the axis to a line between two places (Z, diameter).
    pub(crate) fn frustum([a, b]: [(f64, f64); 2]) -> Self {
        Self { points: vec![(a.0, 0.0), (b.0, 0.0), (b.0, 0.5 * b.1), (a.0, 0.5 * a.1)] }
    }

    /// Corners.
    pub(crate) fn points(&self) -> &[(f64, f64)] {
        &self.points
    }

    /// Moved by (Z, radius).
    pub(crate) fn moved(&self, (z, r): (f64, f64)) -> Self {
        Self { points: self.points.iter().map(|p| (p.0 + z, p.1 + r)).collect() }
    }

    /// The same beyond the axis.
    pub(crate) fn mirrored(&self) -> Self {
        Self { points: self.points.iter().rev().map(|p| (p.0, -p.1)).collect() }
    }

    /// The region that it sweeps on the straight way from `a` to `b`.
    pub(crate) fn swept(&self, a: (f64, f64), b: (f64, f64)) -> Self {
        let at = |by: (f64, f64)| self.points.iter().map(move |p| (p.0 + by.0, p.1 + by.1));
        Self::hull(at(a).chain(at(b)).collect())
    }

    /// Whether the interiors intersect.
    pub(crate) fn meets(&self, other: &Self) -> bool {
        !self.separated_by_box(other) && !self.has_separating_edge(other) && !other.has_separating_edge(self)
    }

    fn separated_by_box(&self, other: &Self) -> bool {
        let ((a0, a1), (b0, b1)) = (self.bounds(), other.bounds());
        a1.0 <= b0.0 + TOUCH_MM
            || b1.0 <= a0.0 + TOUCH_MM
            || a1.1 <= b0.1 + TOUCH_MM
            || b1.1 <= a0.1 + TOUCH_MM
    }

    /// Least and largest Z and radius.
    pub(crate) fn bounds(&self) -> ((f64, f64), (f64, f64)) {
        let wide = ((f64::INFINITY, f64::INFINITY), (f64::NEG_INFINITY, f64::NEG_INFINITY));
        self.points.iter().fold(wide, |(low, high), p| {
            ((low.0.min(p.0), low.1.min(p.1)), (high.0.max(p.0), high.1.max(p.1)))
        })
    }

    /// Lowest radius at a Z; none beside it.
    pub(crate) fn lowest_at(&self, z: f64) -> Option<f64> {
        let n = self.points.len();
        let on_edge = |i: usize| {
            let (a, b) = (self.points[i], self.points[(i + 1) % n]);
            let (low, high) = (a.0.min(b.0), a.0.max(b.0));
            if !(low..=high).contains(&z) {
                return None;
            }
            let share = if high > low { (z - a.0) / (b.0 - a.0) } else { 0.0 };
            let other = if high > low { f64::INFINITY } else { b.1 };
            Some((a.1 + share * (b.1 - a.1)).min(other))
        };
        (0..n).filter_map(on_edge).min_by(f64::total_cmp)
    }

    fn has_separating_edge(&self, other: &Self) -> bool {
        let n = self.points.len();
        (0..n).any(|i| {
            let (a, b) = (self.points[i], self.points[(i + 1) % n]);
            let length = (b.0 - a.0).hypot(b.1 - a.1);
            // the outside lies to the right of an edge
            length > 0.0 && other.points.iter().all(|&p| cross(a, b, p) <= TOUCH_MM * length)
        })
    }
}

/// Twice the area of the triangle a, b, p: positive where p lies to the left of a to b.
fn cross(a: (f64, f64), b: (f64, f64), p: (f64, f64)) -> f64 {
    (b.0 - a.0) * (p.1 - a.1) - (b.1 - a.1) * (p.0 - a.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_square_sweeps_on_a_diagonal_has_no_corners_beside_the_way() {
        let square = Convex::cylinder(0.0, 1.0, 2.0);
        let swept = square.swept((0.0, 0.0), (10.0, 10.0));
        // the corner of the bounding box is free, the middle of the way is not
        assert!(!swept.meets(&Convex::cylinder(8.0, 10.0, 14.0)));
        assert!(swept.meets(&Convex::cylinder(5.0, 6.0, 12.0)));
        assert_eq!(swept.points().len(), 6);
    }

    #[test]
    fn outlines_that_only_touch_do_not_meet() {
        let (a, b) = (Convex::cylinder(0.0, 1.0, 2.0), Convex::cylinder(1.0, 2.0, 2.0));
        assert!(!a.meets(&b) && a.meets(&b.moved((-1e-3, 0.0))));
    }
}
