//! Curves whose tangent is t(a) at the angle a, as pairs of arcs that keep it.
//!
//! Two arcs that meet with a common tangent join two points with given tangents (Bolton, Biarc
//! curves, Computer-Aided Design 7, 1975); with equal lengths d from either end to the corners of
//! their control polygons, (p1 − p0 − d(t0 + t1))² = 4d². The interval of a is halved until all
//! points tested lie within [`TOLERANCE_MM`] of the arcs. Where the curve runs against t it is left
//! out, and a new run begins.

use glam::DVec2;

use crate::outline::{Arc, Piece};

/// Largest distance of the arcs from the curve, mm: a twentieth of the finest increment in use.
const TOLERANCE_MM: f64 = 2e-5;
/// Length below which a stretch of the curve is none, mm: far below every increment.
const NO_LENGTH_MM: f64 = 1e-7;
/// Most halvings: 90° come down to 0.3″.
const MOST_HALVINGS: usize = 20;
/// Points of an interval that are tested.
const TESTED: usize = 9;

/// The runs of a curve between two angles.
pub(super) fn fitted(curve: &dyn Fn(f64) -> DVec2, (from, to): (f64, f64)) -> Vec<Vec<Piece>> {
    let mut runs = vec![Vec::new()];
    fit(curve, (from, to), MOST_HALVINGS, &mut runs);
    runs
}

fn fit(curve: &dyn Fn(f64) -> DVec2, (from, to): (f64, f64), halvings: usize, runs: &mut Vec<Vec<Piece>>) {
    let (p0, p1) = (curve(from), curve(to));
    let middle = 0.5 * (from + to);
    let tested: Vec<(f64, DVec2)> = (1..=TESTED)
        .map(|k| from + (to - from) * k as f64 / (TESTED + 1) as f64)
        .map(|a| (a, curve(a)))
        .collect();
    let points: Vec<DVec2> = [p0].into_iter().chain(tested.iter().map(|t| t.1)).chain([p1]).collect();
    let way: f64 = points.windows(2).map(|w| w[0].distance(w[1])).sum();
    if way < NO_LENGTH_MM {
        return;
    }
    let ahead = DVec2::from_angle(middle).perp();
    let signs = || points.windows(2).map(|w| (w[1] - w[0]).dot(ahead)).filter(|s| s.abs() > NO_LENGTH_MM);
    let (forward, back) = (signs().any(|s| s > 0.0), signs().any(|s| s < 0.0));
    if halvings == 0 || forward != back {
        if back && !forward || halvings == 0 && (p1 - p0).dot(ahead) < 0.0 {
            runs.push(Vec::new());
            return;
        }
        let pair = biarc((p0, from), (p1, to)).filter(|pair| tested.iter().all(|t| is_on(pair, t.1)));
        let pieces = match pair {
            Some(pair) => pair,
            None if halvings == 0 => vec![Piece::line(p0, p1, middle)],
            None => Vec::new(),
        };
        if !pieces.is_empty() {
            if let Some(run) = runs.last_mut() {
                run.extend(pieces);
            }
            return;
        }
    }
    fit(curve, (from, middle), halvings - 1, runs);
    fit(curve, (middle, to), halvings - 1, runs);
}

/// One arc, two arcs or a line from one point to another, with the normals' angles there.
fn biarc((p0, a0): (DVec2, f64), (p1, a1): (DVec2, f64)) -> Option<Vec<Piece>> {
    let (t0, t1) = (DVec2::from_angle(a0).perp(), DVec2::from_angle(a1).perp());
    let (chord, sum) = (p1 - p0, t0 + t1);
    let (product, rest) = (chord.dot(sum), 2.0 * (1.0 - t0.dot(t1)));
    let root = (product * product + rest * chord.length_squared()).sqrt();
    // the root of a quadratic without a difference of like numbers
    let d = chord.length_squared() / (product + root);
    if !(d > 0.0 && d.is_finite()) {
        return None;
    }
    let joint = 0.5 * (p0 + p1 + d * (t0 - t1));
    let tangent = (p1 - p0 - d * sum).try_normalize()?;
    let a = crate::outline::unwrapped((-tangent.perp()).to_angle(), 0.5 * (a0 + a1));
    Some(vec![arc_between((p0, a0), (joint, a)), arc_between((joint, a), (p1, a1))])
}

/// The arc from a point with the normal angle `a0` to another with `a1`.
fn arc_between((p0, a0): (DVec2, f64), (p1, a1): (DVec2, f64)) -> Piece {
    let turn = a1 - a0;
    let chord = (p1 - p0).dot(DVec2::from_angle(0.5 * (a0 + a1)).perp());
    let radius_mm = 0.5 * chord / (0.5 * turn).sin();
    // a sagitta of less than a tenth of a nanometre: a line
    if !radius_mm.is_finite() || chord.abs() * turn.abs() < 1e-9 {
        return Piece::line(p0, p1, 0.5 * (a0 + a1));
    }
    let centre = p0 - radius_mm * DVec2::from_angle(a0);
    Piece { from: p0, to: p1, from_rad: a0, to_rad: a1, arc: Some(Arc { centre, radius_mm }) }
}

fn is_on(pieces: &[Piece], point: DVec2) -> bool {
    pieces.iter().any(|piece| {
        let away = match piece.arc {
            None => (point - piece.from).dot(DVec2::from_angle(piece.from_rad)),
            Some(arc) => point.distance(arc.centre) - arc.radius_mm.abs(),
        };
        let share = piece.share_of(point);
        away.abs() < TOLERANCE_MM && (-0.01..=1.01).contains(&share)
    })
}
