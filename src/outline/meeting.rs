//! Where the carriers of two pieces intersect: whole lines and whole circles.

use glam::DVec2;

use super::piece::{Arc, Piece};

/// Points common to the carriers of two pieces; none where they are parallel or apart, the nearest
/// approach where circles or line and circle touch within rounding.
pub(crate) fn meetings(a: &Piece, b: &Piece) -> Vec<DVec2> {
    match (a.arc, b.arc) {
        (None, None) => of_lines(a, b).into_iter().collect(),
        (None, Some(circle)) => of_line_and_circle(a, circle),
        (Some(circle), None) => of_line_and_circle(b, circle),
        (Some(one), Some(other)) => of_circles(one, other),
    }
}

fn of_lines(a: &Piece, b: &Piece) -> Option<DVec2> {
    let (u, v) = ((a.to - a.from).normalize_or_zero(), (b.to - b.from).normalize_or_zero());
    let sine = u.perp_dot(v);
    // lines that differ by less than the rounding of their directions have no corner
    (sine.abs() > 1e-12).then(|| a.from + u * ((b.from - a.from).perp_dot(v) / sine))
}

/// A share of the radius by which a circle may miss: rounding of coordinates of 100 mm.
const ROUNDING: f64 = 1e-9;

fn of_line_and_circle(line: &Piece, circle: Arc) -> Vec<DVec2> {
    let Some(u) = (line.to - line.from).try_normalize() else { return Vec::new() };
    let base = line.from + u * (circle.centre - line.from).dot(u);
    let (away, r) = (base.distance(circle.centre), circle.radius_mm.abs());
    if away > r * (1.0 + ROUNDING) {
        return Vec::new();
    }
    let half = (r * r - away * away).max(0.0).sqrt();
    vec![base - u * half, base + u * half]
}

fn of_circles(a: Arc, b: Arc) -> Vec<DVec2> {
    let (apart, r, s) = (a.centre.distance(b.centre), a.radius_mm.abs(), b.radius_mm.abs());
    let slack = ROUNDING * (r + s);
    if apart == 0.0 || apart > r + s + slack || apart < (r - s).abs() - slack {
        return Vec::new();
    }
    let u = (b.centre - a.centre) / apart;
    let along = 0.5 * (apart + (r - s) * (r + s) / apart);
    let half = (r * r - along * along).max(0.0).sqrt();
    let base = a.centre + u * along;
    vec![base - u.perp() * half, base + u.perp() * half]
}
