//! Lines and circles through the points of segments, tangent where their segments are: least
//! squares under constraints.
//!
//! A line is n(a)·p = c, a circle |p − C| = |ρ| with ρ below 0 where the outline is concave. A line
//! is tangent to a circle where n·C + ρ = c, two circles are where |C − C'| = |ρ − ρ'|. Gauss and
//! Newton's steps δ solve, with the residuals' derivatives J and the constraints' G,
//!
//! ```text
//! | JᵀJ + εI  Gᵀ | |δ|     |Jᵀr|
//! | G         0  | |λ| = − | g |
//! ```

use std::f64::consts::FRAC_PI_2;

use glam::DVec2;
use nalgebra::{DMatrix, DVector};

use super::segments::{Segment, TANGENT_RAD, circle};
use crate::outline::unwrapped;

/// A whole line or a whole circle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Carrier {
    /// n(a)·p = c.
    Line {
        /// Angle of the normal, rad.
        a_rad: f64,
        /// Distance from the origin, mm.
        c_mm: f64,
        /// Whether the angle stands, as that of a cylinder or an end face.
        fixed: bool,
    },
    /// |p − centre| = |radius|.
    Circle {
        /// Centre, mm.
        centre: DVec2,
        /// Radius, mm; below 0 where the outline is concave.
        radius_mm: f64,
    },
}

/// Most segments, tangent one after the other, whose tangency is kept: a system of equations grows
/// with the cube of their number, and no drawing has as many.
const MOST_CHAIN: usize = 60;
/// Steps of Gauss and Newton: the points determine the carriers within a few nm beforehand.
const STEPS: usize = 6;
/// Weight of an angle that stands, and of what the points leave free.
const FIXED: f64 = 1e8;
const FREE: f64 = 1e-12;

impl Carrier {
    /// Through the points of a segment.
    fn through(points: &[DVec2], segment: Segment, tolerance_mm: f64) -> Self {
        let (from, to) = (points[segment.first], points[segment.last]);
        if segment.is_arc {
            let middle = points[usize::midpoint(segment.first, segment.last)];
            if let Some((centre, radius)) = circle(from, middle, to) {
                // seen along the outline, with the material on one side, a convex arc turns so
                let sign = (middle - from).perp_dot(to - middle).signum();
                return Self::Circle { centre, radius_mm: sign * radius };
            }
        }
        let way = to - from;
        let mut a_rad = unwrapped((-way.perp()).to_angle(), 0.0);
        let square = (a_rad / FRAC_PI_2).round() * FRAC_PI_2;
        let fixed = (a_rad - square).abs() * way.length() <= tolerance_mm;
        if fixed {
            a_rad = square;
        }
        let c_mm = 0.5 * DVec2::from_angle(a_rad).dot(from + to);
        Self::Line { a_rad, c_mm, fixed }
    }

    /// How far a point lies beside it, mm.
    pub(super) fn beside_mm(&self, at: DVec2) -> f64 {
        match *self {
            Self::Line { a_rad, c_mm, .. } => DVec2::from_angle(a_rad).dot(at) - c_mm,
            Self::Circle { centre, radius_mm } => at.distance(centre) - radius_mm.abs(),
        }
    }

    /// Direction of the outline at a point of it, the normal turned by 90°.
    fn along(&self, at: DVec2) -> DVec2 {
        match *self {
            Self::Line { a_rad, .. } => DVec2::from_angle(a_rad).perp(),
            Self::Circle { centre, radius_mm } => {
                (at - centre).normalize_or_zero().perp() * radius_mm.signum()
            }
        }
    }

    /// Derivatives of [`Self::beside_mm`] by its three unknowns.
    fn terms(&self, at: DVec2) -> [f64; 3] {
        match *self {
            Self::Line { a_rad, .. } => [DVec2::from_angle(a_rad).perp().dot(at), -1.0, 0.0],
            Self::Circle { centre, radius_mm } => {
                let out = (at - centre).normalize_or_zero();
                [-out.x, -out.y, -radius_mm.signum()]
            }
        }
    }

    fn stepped(&self, by: [f64; 3]) -> Self {
        match *self {
            Self::Line { a_rad, c_mm, fixed } => {
                Self::Line { a_rad: if fixed { a_rad } else { a_rad + by[0] }, c_mm: c_mm + by[1], fixed }
            }
            Self::Circle { centre, radius_mm } => {
                Self::Circle { centre: centre + DVec2::new(by[0], by[1]), radius_mm: radius_mm + by[2] }
            }
        }
    }
}

/// Whether two carriers are tangent where their segments join.
pub(super) fn are_tangent(a: &Carrier, b: &Carrier, at: DVec2) -> bool {
    let lines = matches!((a, b), (Carrier::Line { .. }, Carrier::Line { .. }));
    !lines && a.along(at).angle_to(b.along(at)).abs() < 10.0 * TANGENT_RAD
}

/// What two tangent carriers miss of their condition, mm, and its derivatives by the unknowns of
/// both.
fn tangency(a: &Carrier, b: &Carrier) -> (f64, [f64; 3], [f64; 3]) {
    match (a, b) {
        (Carrier::Line { a_rad, c_mm, .. }, Carrier::Circle { centre, radius_mm }) => {
            let n = DVec2::from_angle(*a_rad);
            (n.dot(*centre) + radius_mm - c_mm, [n.perp().dot(*centre), -1.0, 0.0], [n.x, n.y, 1.0])
        }
        (Carrier::Circle { .. }, Carrier::Line { .. }) => {
            let (miss, of_b, of_a) = tangency(b, a);
            (miss, of_a, of_b)
        }
        (Carrier::Circle { centre: p, radius_mm: r }, Carrier::Circle { centre: q, radius_mm: s }) => {
            let (apart, u) = (p.distance(*q), (*p - *q).normalize_or_zero());
            let sign = (r - s).signum();
            (apart - (r - s).abs(), [u.x, u.y, -sign], [-u.x, -u.y, sign])
        }
        (Carrier::Line { .. }, Carrier::Line { .. }) => (0.0, [0.0; 3], [0.0; 3]),
    }
}

/// The carriers of segments, and which joints are tangent. Segments that are tangent one after the
/// other are fitted together, those beside a corner apart.
pub(super) fn fitted(points: &[DVec2], segments: &[Segment], tolerance_mm: f64) -> (Vec<Carrier>, Vec<bool>) {
    let mut carriers: Vec<Carrier> =
        segments.iter().map(|s| Carrier::through(points, *s, tolerance_mm)).collect();
    let joint = |i: usize| are_tangent(&carriers[i], &carriers[i + 1], points[segments[i].last]);
    let mut tangent: Vec<bool> = (1..segments.len()).map(|i| joint(i - 1)).collect();
    let mut first = 0;
    while first < segments.len() {
        let last = (first..tangent.len()).find(|i| !tangent[*i]).unwrap_or(segments.len() - 1);
        if last - first >= MOST_CHAIN {
            tangent[first..last].fill(false);
            continue;
        }
        fit(points, &segments[first..=last], &mut carriers[first..=last], &tangent[first..last]);
        first = last + 1;
    }
    (carriers, tangent)
}

/// Fits carriers that are tangent one after the other.
fn fit(points: &[DVec2], segments: &[Segment], carriers: &mut [Carrier], tangent: &[bool]) {
    for _ in 0..STEPS {
        let Some(step) = step(points, segments, carriers, tangent) else { break };
        for (i, carrier) in carriers.iter_mut().enumerate() {
            *carrier = carrier.stepped([step[3 * i], step[3 * i + 1], step[3 * i + 2]]);
        }
    }
}

fn step(
    points: &[DVec2],
    segments: &[Segment],
    carriers: &[Carrier],
    tangent: &[bool],
) -> Option<DVector<f64>> {
    let n = 3 * segments.len();
    let joints: Vec<usize> = (0..tangent.len()).filter(|i| tangent[*i]).collect();
    let mut matrix = DMatrix::zeros(n + joints.len(), n + joints.len());
    let mut right = DVector::zeros(n + joints.len());
    for (i, (segment, carrier)) in segments.iter().zip(carriers).enumerate() {
        for point in &points[segment.first..=segment.last] {
            let (terms, beside) = (carrier.terms(*point), carrier.beside_mm(*point));
            for (k, l) in (0..3).flat_map(|k| (0..3).map(move |l| (k, l))) {
                matrix[(3 * i + k, 3 * i + l)] += terms[k] * terms[l];
            }
            (0..3).for_each(|k| right[3 * i + k] -= terms[k] * beside);
        }
        (0..3).for_each(|k| matrix[(3 * i + k, 3 * i + k)] += FREE);
        match carrier {
            Carrier::Line { fixed, .. } => {
                matrix[(3 * i, 3 * i)] += if *fixed { FIXED } else { 0.0 };
                matrix[(3 * i + 2, 3 * i + 2)] += 1.0;
            }
            Carrier::Circle { .. } => {}
        }
    }
    for (row, &i) in joints.iter().enumerate() {
        let (miss, of_a, of_b) = tangency(&carriers[i], &carriers[i + 1]);
        for (k, term) in of_a.into_iter().chain(of_b).enumerate() {
            // an angle that stands takes no part in a constraint
            let stands = matches!(carriers[i + k / 3], Carrier::Line { fixed: true, .. }) && k % 3 == 0;
            let term = if stands { 0.0 } else { term };
            matrix[(n + row, 3 * i + k)] = term;
            matrix[(3 * i + k, n + row)] = term;
        }
        right[n + row] = -miss;
    }
    matrix.lu().solve(&right)
}
