//! Points of a profile into lines and arcs.
//!
//! Points of an arc lie on one circle at equal angles, as exporters divide it, or are six at least.
//! Four corners of a trapezoid lie on a circle as well: steps of an arc turn by 31° at most. Three
//! points are an arc only where their circle is tangent to the lines on both sides. A line ends
//! where an arc begins, although the first points of a fine arc lie on the line within any
//! tolerance.

use std::f64::consts::FRAC_PI_2;

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
    let mut fan = Fan::new(points[first], points[last] - points[first]);
    while last + 1 < points.len()
        && fan.goes_on(points[last], points[last + 1], tolerance_mm)
        && longest_arc(points, last, tolerance_mm).is_none()
    {
        last += 1;
    }
    Segment { first, last, is_arc: false }
}

/// Directions of lines from one point that pass the points behind it within a tolerance and along
/// which the points run forward: one more point costs the same however many there are.
struct Fan {
    from: DVec2,
    /// Direction of the first chord, from which the others are counted.
    along: DVec2,
    low_rad: f64,
    high_rad: f64,
}

impl Fan {
    fn new(from: DVec2, along: DVec2) -> Self {
        Self { from, along, low_rad: -FRAC_PI_2, high_rad: FRAC_PI_2 }
    }

    fn narrow(&mut self, middle_rad: f64, half_rad: f64) {
        self.low_rad = self.low_rad.max(middle_rad - half_rad);
        self.high_rad = self.high_rad.min(middle_rad + half_rad);
    }

    /// Whether the line to `next` passes the points up to `last`, which it takes in.
    fn goes_on(&mut self, last: DVec2, next: DVec2, tolerance_mm: f64) -> bool {
        let angle = |way: DVec2| self.along.angle_to(way);
        let (seen, chord, end) = (angle(last - self.from), angle(next - last), angle(next - self.from));
        let share = tolerance_mm / last.distance(self.from);
        if share < 1.0 {
            self.narrow(seen, share.asin());
        }
        self.narrow(chord, FRAC_PI_2);
        self.low_rad <= end && end <= self.high_rad
    }
}

/// The longest arc from a point on. Whether points are one is asked at ends that stand further and
/// further off and halved in between: an arc goes on as long as every part of it.
fn longest_arc(points: &[DVec2], first: usize, tolerance_mm: f64) -> Option<Segment> {
    let holds = |last: usize| is_arc(&points[first..=last], tolerance_mm);
    let arc = |last: usize| Segment { first, last, is_arc: true };
    let Some(mut found) = first_arc(points, first, tolerance_mm) else {
        return tangent_three(points, first, tolerance_mm).then(|| arc(first + 2));
    };
    let (mut stride, end) = (1, points.len());
    while found + stride < end && holds(found + stride) {
        found += stride;
        stride *= 2;
    }
    let mut beyond = (found + stride).min(end);
    while beyond - found > 1 {
        let middle = usize::midpoint(found, beyond);
        if holds(middle) { found = middle } else { beyond = middle }
    }
    Some(arc(found))
}

/// The last point of the shortest arc of four points or more: the first points of a fine one are a
/// line within the tolerance yet.
fn first_arc(points: &[DVec2], first: usize, tolerance_mm: f64) -> Option<usize> {
    let mut again = 0;
    for last in first + 3..points.len() {
        let run = &points[first..=last];
        if sagitta_mm(run) >= LEAST_SAGITTA * tolerance_mm && last >= again {
            if is_arc(run, tolerance_mm) {
                return Some(last);
            }
            // what is no arc here is hardly one a point further on
            again = last + (last - first).div_ceil(4);
        }
        if !bends(points, first, last) {
            return None;
        }
    }
    None
}

/// How far the middle one of points stands off the line from the first to the last, mm.
fn sagitta_mm(points: &[DVec2]) -> f64 {
    let last = points.len() - 1;
    (points[last] - points[0]).normalize_or_zero().perp_dot(points[last / 2] - points[0]).abs()
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
    if sagitta_mm(points) < LEAST_SAGITTA * tolerance_mm {
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
