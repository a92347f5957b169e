//! Points of a profile into lines and arcs.
//!
//! Points of an arc lie on one circle at equal angles, as exporters divide it, or are six at least.
//! Four corners of a trapezoid lie on a circle as well: steps of an arc turn by 31° at most. Three
//! points are an arc only where their circle is tangent to the lines on both sides. A line ends where
//! an arc begins, although the first points of a fine arc lie on the line within any tolerance.

use glam::DVec2;

/// A run of points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Segment {
    /// Number of its first point.
    pub(super) first: usize,
    /// Number of its last point.
    pub(super) last: usize,
    /// Whether it is an arc.
    pub(super) is_arc: bool,
}

/// Largest turn from chord to chord, rad: three steps of a quarter.
const MOST_STEP_RAD: f64 = 31.0 * std::f64::consts::PI / 180.0;
/// Largest such turn of three points that are tangent on both sides, rad: two steps of a quarter.
const MOST_SINGLE_RAD: f64 = 61.0 * std::f64::consts::PI / 180.0;
/// Difference of chords of one arc, as a share.
const UNEVEN: f64 = 0.01;
/// Points from which an arc may have uneven chords.
const MANY: usize = 6;
/// Sagitta from which points are an arc and no line, in units of the tolerance.
const LEAST_SAGITTA: f64 = 4.0;
/// Angle between a circle and the line beside it that are tangent, rad: 0.1 µm on 1 mm.
pub(super) const TANGENT_RAD: f64 = 1e-4;

/// The segments of points, each beginning where the one before ends; lines and arcs pass their
/// points within `tolerance_mm`.
pub(super) fn of(points: &[DVec2], tolerance_mm: f64) -> Vec<Segment> {
    let mut segments = Vec::new();
    let mut first = 0;
    while first + 1 < points.len() {
        let arc = longest_arc(points, first, tolerance_mm);
        let segment = arc.unwrap_or_else(|| longest_line(points, first, tolerance_mm));
        first = segment.last;
        segments.push(segment);
    }
    segments
}

fn longest_line(points: &[DVec2], first: usize, tolerance_mm: f64) -> Segment {
    let mut last = first + 1;
    let goes_on = |last: usize| {
        last + 1 < points.len()
            && is_line(&points[first..=last + 1], tolerance_mm)
            && longest_arc(points, last, tolerance_mm).is_none()
    };
    while goes_on(last) {
        last += 1;
    }
    Segment { first, last, is_arc: false }
}

fn is_line(points: &[DVec2], tolerance_mm: f64) -> bool {
    let (from, to) = (points[0], points[points.len() - 1]);
    let Some(along) = (to - from).try_normalize() else { return false };
    let forward = points.windows(2).all(|w| (w[1] - w[0]).dot(along) > 0.0);
    forward && points.iter().all(|p| along.perp_dot(*p - from).abs() <= tolerance_mm)
}

fn longest_arc(points: &[DVec2], first: usize, tolerance_mm: f64) -> Option<Segment> {
    let mut found = tangent_three(points, first, tolerance_mm).then_some(first + 2);
    let mut last = first + 3;
    // of a fine arc the first points are a line yet: more of them decide
    while last < points.len()
        && (is_arc(&points[first..=last], tolerance_mm) || found.is_none() && bends(points, first, last))
    {
        if is_arc(&points[first..=last], tolerance_mm) {
            found = Some(last);
        }
        last += 1;
    }
    found.map(|last| Segment { first, last, is_arc: true })
}

/// Whether points go on bending to one side in equal steps, as those of an arc do.
fn bends(points: &[DVec2], first: usize, last: usize) -> bool {
    let chord = |i: usize| points[i + 1] - points[i];
    let turn = |i: usize| chord(i).angle_to(chord(i + 1));
    let (start, now) = (turn(first), turn(last - 2));
    let lengths = (chord(first).length(), chord(last - 1).length());
    start * now > 0.0
        && (now - start).abs() < 0.5 * start.abs()
        && (lengths.0 - lengths.1).abs() < UNEVEN * lengths.0
        && now.abs() <= MOST_STEP_RAD
}

/// Centre and radius of the circle through three points.
pub(super) fn circle(a: DVec2, b: DVec2, c: DVec2) -> Option<(DVec2, f64)> {
    let (u, v) = (b - a, c - a);
    let double = 2.0 * u.perp_dot(v);
    if double.abs() < 1e-9 * u.length() * v.length() {
        return None;
    }
    let from = DVec2::new(
        v.y * u.length_squared() - u.y * v.length_squared(),
        u.x * v.length_squared() - v.x * u.length_squared(),
    ) / double;
    Some((a + from, from.length()))
}

fn is_arc(points: &[DVec2], tolerance_mm: f64) -> bool {
    let last = points.len() - 1;
    let Some((centre, radius)) = circle(points[0], points[last / 2], points[last]) else { return false };
    let chords: Vec<DVec2> = points.windows(2).map(|w| w[1] - w[0]).collect();
    let turns = || chords.windows(2).map(|w| w[0].angle_to(w[1]));
    let sense = turns().next().unwrap_or(0.0).signum();
    if !turns().all(|turn| turn * sense > 0.0 && turn.abs() <= MOST_STEP_RAD) {
        return false;
    }
    // digits of a file bend a line of many turns as well
    let along = (points[last] - points[0]).normalize_or_zero();
    let sagitta = points.iter().map(|p| along.perp_dot(*p - points[0]).abs()).fold(0.0, f64::max);
    if sagitta < LEAST_SAGITTA * tolerance_mm {
        return false;
    }
    let (least, most) = chords
        .iter()
        .map(|c| c.length())
        .fold((f64::INFINITY, 0.0_f64), |(low, high), c| (low.min(c), high.max(c)));
    let even = points.len() >= MANY || most - least <= UNEVEN * most + 2.0 * tolerance_mm;
    even && points.iter().all(|p| (p.distance(centre) - radius).abs() <= tolerance_mm)
}

/// Whether three points are an arc that is tangent to the lines before and behind it.
fn tangent_three(points: &[DVec2], first: usize, tolerance_mm: f64) -> bool {
    let Some([before, a, b, c, behind]) = first.checked_sub(1).and_then(|i| points.get(i..i + 5)) else {
        return false;
    };
    let Some((centre, _)) = circle(*a, *b, *c) else { return false };
    let turn = (*b - *a).angle_to(*c - *b);
    let is_tangent = |at: DVec2, along: DVec2| {
        let across = (at - centre).normalize_or_zero();
        along.normalize_or_zero().dot(across).abs() < TANGENT_RAD
    };
    let sagitta = (*c - *a).normalize_or_zero().perp_dot(*b - *a).abs();
    let bends = sagitta >= LEAST_SAGITTA * tolerance_mm && turn.abs() <= MOST_SINGLE_RAD;
    bends && is_tangent(*a, *a - *before) && is_tangent(*c, *behind - *c)
}
