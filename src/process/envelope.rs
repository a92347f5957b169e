//! The surface that a nose leaves on its path: for every z the smallest radius that any place of
//! the path and any point of the nose come to.
//!
//! With the tool point at O the nose's edge towards the axis is the curve of the points O + p, a
//! convex function X over Z. Along a straight move the smallest of its copies is the copy at either
//! end, or the line on which the point runs that has the move for its tangent. So the envelope of a
//! path of straight moves is the least of such curves and lines. A nose that is flatter than a
//! concave arc cuts into it, and a concave corner keeps the nose's own fillet, without any rule for
//! either.
//!
//! In: the nose and the moves of its tool point. Out: the radius along z, in knots.

use glam::DVec2;

use crate::nose::NoseProfile;

/// A nose on its path, for shafts.
#[derive(Clone, Debug)]
pub(crate) struct NosePath {
    /// Points p (X, Z) of its edge towards the axis about the tool point, Z ascending.
    edge: Vec<DVec2>,
    moves: Vec<Move>,
}

/// A straight move of the tool point.
#[derive(Clone, Copy, Debug)]
struct Move {
    from: DVec2,
    to: DVec2,
    /// The point of the nose that has the move for its tangent; none along X.
    touching: Option<DVec2>,
}

/// Distance of the directions that give the nose's edge, rad: 0.1° leave r·Δ²/8 = 0.15 nm of
/// 0.4 mm.
const STEP_RAD: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// Distance of the first knots, mm: a tenth of the smallest nose radius of ISO 3685, so that every
/// fillet has several.
const FIRST_MM: f64 = 0.04;
/// Least distance of knots, mm: five times the departure, so that a jump is divided down to it.
const LEAST_MM: f64 = 1e-5;
/// Rise over that length from which it is a shoulder, mm: the chord next to the steepest point of
/// the nose's edge rises by 1/tan(STEP/2) as much, .011 mm.
const SHOULDER_MM: f64 = 0.02;
/// Largest distance of the surface from the line between knots, mm: a fiftieth of the best
/// uncertainty of a gauge.
const CHORD_MM: f64 = 2e-6;
/// Cosine below which a move runs along X and has no length in z.
const ALONG_X: f64 = 1e-9;

impl NosePath {
    /// A nose and the straight moves of its tool point, (X, Z) in mm.
    pub(crate) fn new(nose: &NoseProfile, moves: &[(DVec2, DVec2)]) -> Self {
        let (low, high) = nose.range_rad();
        // beyond ±90° the edge turns back over itself
        let (low, high) = (low.max(-std::f64::consts::FRAC_PI_2), high.min(std::f64::consts::FRAC_PI_2));
        let steps = ((high - low) / STEP_RAD).ceil().max(1.0) as usize;
        let at = |k: usize| -nose.contact(high - (high - low) * k as f64 / steps as f64);
        let of = |&(from, to): &(DVec2, DVec2)| Move { from, to, touching: touching(nose, to - from) };
        Self { edge: (0..=steps).map(at).collect(), moves: moves.iter().map(of).collect() }
    }

    /// Radius that is left at z, mm; none where no place of the nose comes.
    pub(crate) fn radius_mm(&self, z_mm: f64) -> Option<f64> {
        self.moves.iter().filter_map(|m| self.of_move(m, z_mm)).min_by(f64::total_cmp)
    }

    fn of_move(&self, m: &Move, z_mm: f64) -> Option<f64> {
        let (first, last) = (self.edge[0].y, self.edge[self.edge.len() - 1].y);
        if z_mm < m.from.y.min(m.to.y) + first || z_mm > m.from.y.max(m.to.y) + last {
            return None;
        }
        let ends = [m.from, m.to].into_iter().filter_map(|o| Some(o.x + self.height(z_mm - o.y)?));
        let line = m.touching.and_then(|p| {
            let share = (z_mm - m.from.y - p.y) / (m.to.y - m.from.y);
            (0.0..=1.0).contains(&share).then_some(p.x + m.from.x + share * (m.to.x - m.from.x))
        });
        ends.chain(line).min_by(f64::total_cmp)
    }

    /// X of the edge at the distance `z_mm` along Z from the tool point.
    fn height(&self, z_mm: f64) -> Option<f64> {
        let next = self.edge.partition_point(|p| p.y < z_mm);
        let b = self.edge.get(next)?;
        let Some(a) = next.checked_sub(1).map(|i| self.edge[i]) else {
            return (b.y == z_mm).then_some(b.x);
        };
        Some(a.x + (b.x - a.x) * (z_mm - a.y) / (b.y - a.y))
    }

    /// The surface from `from_mm` to `to_mm`, as knots (z, radius) in mm, linear between; two at
    /// one z are a shoulder.
    ///
    /// # Errors
    /// A z that no place of the nose comes to.
    pub(crate) fn surface(&self, (from_mm, to_mm): (f64, f64)) -> Result<Vec<(f64, f64)>, f64> {
        let pieces = ((to_mm - from_mm) / FIRST_MM).ceil().max(1.0) as usize;
        let at = |k: usize| from_mm + (to_mm - from_mm) * k as f64 / pieces as f64;
        let knot = |z: f64| self.radius_mm(z).map(|r| (z, r)).ok_or(z);
        let mut knots = vec![knot(from_mm)?];
        for k in 0..pieces {
            let ends = (knot(at(k))?, knot(at(k + 1))?);
            self.refine(ends, &mut knots)?;
            knots.push(ends.1);
        }
        Ok(thinned(&knots))
    }

    /// The knots between two.
    fn refine(&self, (a, b): ((f64, f64), (f64, f64)), into: &mut Vec<(f64, f64)>) -> Result<(), f64> {
        let knot = |z: f64| self.radius_mm(z).map(|r| (z, r)).ok_or(z);
        if b.0 - a.0 <= LEAST_MM {
            if (b.1 - a.1).abs() > SHOULDER_MM {
                let z = 0.5 * (a.0 + b.0);
                into.extend([(z, a.1), (z, b.1)]);
            }
            return Ok(());
        }
        // places that no symmetric curve has on its chord at once
        let between = [0.24, 0.5, 0.69].map(|share| a.0 + share * (b.0 - a.0));
        let inner = [knot(between[0])?, knot(between[1])?, knot(between[2])?];
        if inner.iter().all(|k| away(*k, a, b) <= CHORD_MM) {
            return Ok(());
        }
        self.refine((a, inner[1]), into)?;
        into.push(inner[1]);
        self.refine((inner[1], b), into)
    }
}

/// The point of a nose that has a way for its tangent.
fn touching(nose: &NoseProfile, way: DVec2) -> Option<DVec2> {
    let n = way.try_normalize()?.perp();
    let n = if n.x < 0.0 { -n } else { n };
    (n.x > ALONG_X).then(|| -nose.contact(n.to_angle()))
}

/// How far a knot lies from the line between two, mm.
fn away(knot: (f64, f64), a: (f64, f64), b: (f64, f64)) -> f64 {
    let (along, to) = (DVec2::new(b.0 - a.0, b.1 - a.1), DVec2::new(knot.0 - a.0, knot.1 - a.1));
    along.perp_dot(to).abs() / along.length().max(f64::MIN_POSITIVE)
}

/// The knots without those that lie on the line between others (Douglas and Peucker 1973).
fn thinned(knots: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut kept = vec![false; knots.len()];
    kept[0] = true;
    kept[knots.len() - 1] = true;
    let mut open = vec![(0, knots.len() - 1)];
    while let Some((a, b)) = open.pop() {
        let far = |i: usize| away(knots[i], knots[a], knots[b]);
        let Some(most) = (a + 1..b).max_by(|i, j| far(*i).total_cmp(&far(*j))) else { continue };
        if far(most) > CHORD_MM {
            kept[most] = true;
            open.extend([(a, most), (most, b)]);
        }
    }
    knots.iter().zip(kept).filter(|(_, kept)| *kept).map(|(knot, _)| *knot).collect()
}
