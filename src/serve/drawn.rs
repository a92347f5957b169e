//! A table of moves as the polylines that a page draws.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Distance of what is drawn from the moves at most, mm: chords of an arc are joined up to it.
const WITHIN_MM: f64 = 2e-5;
/// Moves joined into one at most: the search for the longest chord stays short.
const MOST_JOINED: usize = 64;

/// Moves of a kind behind each other.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct Polyline {
    /// `rapid`, `roughing` or `finishing`.
    kind: String,
    /// Places: Z and X (diameter), mm.
    points_mm: Vec<[f64; 2]>,
}

#[derive(Deserialize)]
struct Row {
    from_diameter_mm: f64,
    from_z_mm: f64,
    to_diameter_mm: f64,
    to_z_mm: f64,
    kind: String,
}

/// Reads a table of moves.
///
/// # Errors
/// A table of another kind.
pub(super) fn polylines(table: &[u8]) -> Result<Vec<Polyline>, csv::Error> {
    let mut all: Vec<Polyline> = Vec::new();
    for row in csv::Reader::from_reader(table).deserialize() {
        let row: Row = row?;
        let from = [row.from_z_mm, row.from_diameter_mm];
        let goes_on = all.last().is_some_and(|l| l.kind == row.kind && l.points_mm.last() == Some(&from));
        if !goes_on {
            all.push(Polyline { kind: row.kind, points_mm: vec![from] });
        }
        if let Some(last) = all.last_mut() {
            last.points_mm.push([row.to_z_mm, row.to_diameter_mm]);
        }
    }
    all.iter_mut().for_each(|line| line.points_mm = thinned(&line.points_mm));
    Ok(all)
}

/// Joins chords while every place between lies within [`WITHIN_MM`] of the longer one.
fn thinned(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = points.first().copied().into_iter().collect();
    let mut at = 0;
    while at + 1 < points.len() {
        let mut to = at + 1;
        while to + 1 < points.len()
            && to + 1 - at <= MOST_JOINED
            && points[at + 1..=to].iter().all(|p| distance_mm(*p, points[at], points[to + 1]) <= WITHIN_MM)
        {
            to += 1;
        }
        kept.push(points[to]);
        at = to;
    }
    kept
}

/// Distance of a place from the chord between two others; X as a radius.
fn distance_mm(p: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let at = |q: [f64; 2]| glam::DVec2::new(q[0], 0.5 * q[1]);
    let (p, from, to) = (at(p), at(from), at(to));
    let along = to - from;
    let share = ((p - from).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    p.distance(from + share * along)
}

#[cfg(test)]
mod tests {
    use super::{WITHIN_MM, distance_mm, thinned};

    #[test]
    fn chords_of_an_arc_are_joined_and_corners_stay() {
        let arc = |k: u32| {
            let (sin, cos) = (f64::from(k) * 1e-3).sin_cos();
            [5.0 * sin, 10.0 * cos]
        };
        let mut points: Vec<[f64; 2]> = (0..=1000).map(arc).collect();
        let corner = points[1000];
        points.push([corner[0] + 3.0, corner[1]]);
        // chords of 28 µm on a radius of 5 mm lie 20 nm beside it: five steps each
        let kept = thinned(&points);
        assert!(kept.len() < 250 && kept.contains(&corner), "{}", kept.len());
        let nearest =
            |p: &[f64; 2]| kept.windows(2).map(|w| distance_mm(*p, w[0], w[1])).fold(f64::INFINITY, f64::min);
        assert!(points.iter().all(|p| nearest(p) <= WITHIN_MM));
    }
}
