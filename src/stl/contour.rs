//! The outside of a model as an outline of lines and arcs.

use glam::DVec2;

use super::carriers::{self, Carrier};
use super::segments;
use crate::outline::{Arc, Outline, Piece, Side, meetings, unwrapped};

/// An outline through points.
#[derive(Clone, Debug)]
pub(super) struct Contour {
    /// The outline.
    pub(super) outline: Outline,
    /// Largest distance of a point from it, mm.
    pub(super) departure_mm: f64,
}

/// Distance from a line or an arc that passes as noise, in units of the largest found about the
/// turns, which are means of many vertices.
const NOISE_FACTOR: f64 = 4.0;
/// Noise of a file in which none was found, mm: single precision of 10 mm.
const LEAST_NOISE_MM: f64 = 1e-6;
/// Length below which a piece is none, mm.
const NO_LENGTH_MM: f64 = 1e-7;

/// The outline through the points of an outside, within `tolerance_mm`; `noise_mm` is how far they
/// lie beside it by the file's digits.
///
/// Lines and arcs of a drawing pass their points within the noise. Only where the tolerance needs
/// fewer than half as many pieces, on a curve that is neither, is it used.
pub(super) fn through(points: &[DVec2], (tolerance_mm, noise_mm): (f64, f64)) -> Contour {
    let exact_mm = tolerance_mm.min(NOISE_FACTOR * noise_mm.max(LEAST_NOISE_MM));
    let (exact, rough) = (segments::of(points, exact_mm), segments::of(points, tolerance_mm));
    let (segments, tolerance_mm) =
        if 2 * rough.len() < exact.len() { (rough, tolerance_mm) } else { (exact, exact_mm) };
    let (carriers, tangent) = carriers::fitted(points, &segments, tolerance_mm);
    let mut joints = vec![onto(&carriers[0], points[0])];
    for i in 1..segments.len() {
        let at = points[segments[i].first];
        joints.push(joint((&carriers[i - 1], &carriers[i]), at, tangent[i - 1]));
    }
    joints.push(onto(&carriers[carriers.len() - 1], points[points.len() - 1]));
    let piece = |(i, carrier): (usize, &Carrier)| piece(carrier, joints[i], joints[i + 1]);
    let pieces = carriers.iter().enumerate().map(piece).filter(|p| p.length_mm() > NO_LENGTH_MM).collect();
    let beside = segments
        .iter()
        .zip(&carriers)
        .flat_map(|(s, c)| points[s.first..=s.last].iter().map(|p| c.beside_mm(*p).abs()));
    let departure_mm = beside.fold(0.0, f64::max);
    Contour { outline: Outline { pieces, side: Side::External }, departure_mm }
}

/// The point of a carrier next to another point; on the axis it stays on the axis.
fn onto(carrier: &Carrier, at: DVec2) -> DVec2 {
    let found = match *carrier {
        Carrier::Line { a_rad, .. } => at - carrier.beside_mm(at) * DVec2::from_angle(a_rad),
        Carrier::Circle { centre, radius_mm } => centre + radius_mm.abs() * (at - centre).normalize_or_zero(),
    };
    if at.x == 0.0 { DVec2::new(0.0, found.y) } else { found }
}

/// Where two carriers join next to a point.
fn joint((a, b): (&Carrier, &Carrier), at: DVec2, is_tangent: bool) -> DVec2 {
    let on_normal = |centre: DVec2, radius_mm: f64, n: DVec2| centre + radius_mm * n;
    match (a, b) {
        (Carrier::Line { a_rad, .. }, Carrier::Circle { centre, radius_mm })
        | (Carrier::Circle { centre, radius_mm }, Carrier::Line { a_rad, .. })
            if is_tangent =>
        {
            on_normal(*centre, *radius_mm, DVec2::from_angle(*a_rad))
        }
        (Carrier::Circle { centre: p, radius_mm: r }, Carrier::Circle { centre: q, radius_mm: s })
            if is_tangent =>
        {
            on_normal(*p, *r, ((*q - *p) / (r - s)).normalize_or_zero())
        }
        _ => {
            let whole = |c: &Carrier| piece(c, at, at);
            let found = meetings(&whole(a), &whole(b)).into_iter();
            found.min_by(|m, n| m.distance(at).total_cmp(&n.distance(at))).unwrap_or(at)
        }
    }
}

/// The part of a carrier between two points; of equal points the carrier itself.
fn piece(carrier: &Carrier, from: DVec2, to: DVec2) -> Piece {
    match *carrier {
        Carrier::Line { a_rad, .. } if from == to => {
            Piece::line(from, from + DVec2::from_angle(a_rad).perp(), a_rad)
        }
        Carrier::Line { a_rad, .. } => Piece::line(from, to, a_rad),
        Carrier::Circle { centre, radius_mm } => {
            let angle = |p: DVec2| ((p - centre) * radius_mm.signum()).to_angle();
            let from_rad = unwrapped(angle(from), 0.0);
            let to_rad = unwrapped(angle(to), from_rad);
            Piece { from, to, from_rad, to_rad, arc: Some(Arc { centre, radius_mm }) }
        }
    }
}
