//! What a path leaves of a part: at every place of the outline, how far from it along the normal
//! the first nose on the path lies.
//!
//! The nose at O takes up the points x with (O − x)·n_i ≤ h_i for all directions n_i. Along a
//! straight move it sweeps the sum of itself and the move: the same half-planes, each moved to the
//! end of the move that reaches further, and the one along the move with its own support. A ray
//! from the surface enters this convex region where the last of its half-planes begins. The nearest
//! entry of all moves is what is left, below 0 where the nose cuts too deep. Nothing of the
//! construction of the path is used.

use glam::DVec2;

use super::chain::Element;
use crate::nose::NoseProfile;
use crate::outline::{Outline, Piece, unwrapped};

/// What is left at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Remainder {
    /// Number of the outline's piece, from 0.
    pub source: usize,
    /// The place (X, Z), mm.
    pub at: DVec2,
    /// Angle of the normal, rad.
    pub a_rad: f64,
    /// Left along the normal, mm.
    pub left_mm: f64,
    /// Whether the tool touches here: not in the fillet of a concave corner.
    pub reached: bool,
}

/// Directions of the nose's half-planes, rad: 0.1° leave r·Δ²/8 = 0.15 nm of 0.4 mm.
const STEP_RAD: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// Share of the half-planes that sort the moves.
const COARSE: usize = 60;
/// Largest sagitta of the chords of a path's arcs, mm.
const SAGITTA_MM: f64 = 1e-6;
/// Places a line, and least number a piece.
const PLACES: usize = 16;
/// Distance of places along an arc, rad.
const PLACE_RAD: f64 = std::f64::consts::PI / 180.0;
/// Moves further off than this many times the nose's size do not count: the nose is given about its
/// tip only.
const REACH: f64 = 4.0;

/// A nose as the half-planes (n, h) that bound it.
#[derive(Clone, Debug)]
pub(crate) struct Tool<'a> {
    nose: &'a NoseProfile,
    bounds: Vec<(DVec2, f64)>,
    /// A few of the bounds: the region within them contains the nose, and a ray enters it earlier.
    coarse: Vec<(DVec2, f64)>,
    reach_mm: f64,
}

impl<'a> Tool<'a> {
    /// The half-planes of a nose.
    pub(crate) fn new(nose: &'a NoseProfile) -> Self {
        let bounds: Vec<(DVec2, f64)> =
            nose.supports(STEP_RAD).into_iter().map(|(a, h)| (DVec2::from_angle(a), h)).collect();
        let (low, high) = nose.range_rad();
        let middle = 0.5 * (low + high);
        let size = [low, middle, high].map(|a| nose.contact(a).length()).into_iter().fold(0.0, f64::max);
        let coarse = bounds.iter().step_by(COARSE).copied().collect();
        Self { nose, bounds, coarse, reach_mm: REACH * size }
    }

    /// Where the ray `from` + λ·`along` enters what the nose sweeps on the way from `a` to `b`, mm.
    fn entry(
        &self,
        (from, along): (DVec2, DVec2),
        (a, b): (DVec2, DVec2),
        bounds: &[(DVec2, f64)],
    ) -> Option<f64> {
        let (mut first, mut last) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut bound = |n: DVec2, h: f64| {
            let (slope, offset) = (along.dot(n), h + from.dot(n) - a.dot(n).min(b.dot(n)));
            if slope > 1e-12 {
                first = first.max(-offset / slope);
            } else if slope < -1e-12 {
                last = last.min(-offset / slope);
            } else if offset < 0.0 {
                last = f64::NEG_INFINITY;
            }
        };
        bounds.iter().for_each(|&(n, h)| bound(n, h));
        if let Some(way) = (b - a).try_normalize() {
            let (low, high) = self.nose.range_rad();
            for n in [way.perp(), -way.perp()] {
                let angle = unwrapped(n.to_angle(), 0.5 * (low + high));
                if (low..=high).contains(&angle) {
                    bound(n, self.nose.support_mm(angle));
                }
            }
        }
        (first <= last).then_some(first)
    }
}

/// What a path of the tool point, in straight moves, leaves at a place.
fn left_at(tool: &Tool<'_>, moves: &[(DVec2, DVec2)], at: DVec2, a: f64) -> Option<f64> {
    let along = DVec2::from_angle(a);
    let near = |m: &&(DVec2, DVec2)| {
        let (way, length) = (m.1 - m.0, m.0.distance_squared(m.1));
        let share = if length > 0.0 { ((at - m.0).dot(way) / length).clamp(0.0, 1.0) } else { 0.0 };
        (m.0 + share * way).distance(at) < tool.reach_mm
    };
    let ray = (at, along);
    let early = |&m: &(DVec2, DVec2)| Some((tool.entry(ray, m, &tool.coarse)?, m));
    let mut moves: Vec<(f64, (DVec2, DVec2))> = moves.iter().filter(near).filter_map(early).collect();
    moves.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut nearest: Option<f64> = None;
    for (early, m) in moves {
        if nearest.is_some_and(|nearest| nearest <= early) {
            break;
        }
        let entry = tool.entry(ray, m, &tool.bounds);
        nearest = entry.into_iter().chain(nearest).min_by(f64::total_cmp);
    }
    nearest
}

/// What a path leaves over the whole outline; places that no move comes near are left out.
pub(crate) fn remainders(
    outline: &Outline,
    path: &[Element],
    moves: &[(DVec2, DVec2)],
    tool: &Tool<'_>,
) -> Vec<Remainder> {
    let mut found = Vec::new();
    for (source, piece) in outline.pieces.iter().enumerate() {
        // an odd number has a place in the middle
        let turn = (piece.to_rad - piece.from_rad).abs();
        let places = ((turn / PLACE_RAD).ceil() as usize).max(PLACES) | 1;
        for k in 0..places {
            let share = (k as f64 + 0.5) / places as f64;
            let (at, a_rad) = (piece.at(share), piece.angle_at(share));
            let Some(left_mm) = left_at(tool, moves, at, a_rad) else { continue };
            let of = path.iter().filter(|e| e.source == source).map(|e| e.piece);
            let reached = touches(of, piece.arc.is_some(), at + tool.nose.contact(a_rad), a_rad);
            found.push(Remainder { source, at, a_rad, left_mm, reached });
        }
    }
    found
}

/// Whether a place with the normal `a` lies between the first and the last place that the path
/// touches of its piece: only the fillets of concave corners lie beside.
fn touches(path: impl Iterator<Item = Piece>, on_arc: bool, tool_point: DVec2, a: f64) -> bool {
    // trimmed ends differ by the way's own error from where the nose would stand
    const SLACK_MM: f64 = 0.02;
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for piece in path {
        if on_arc {
            low = low.min(piece.from_rad.min(piece.to_rad));
            high = high.max(piece.from_rad.max(piece.to_rad));
        } else if piece.arc.is_none() {
            let slack = SLACK_MM / piece.length_mm().max(SLACK_MM);
            if (-slack..=1.0 + slack).contains(&piece.share_of(tool_point)) {
                return true;
            }
        }
    }
    (low..=high).contains(&a)
}

/// The straight moves of a path.
pub(crate) fn moves_of(path: &[Element]) -> Vec<(DVec2, DVec2)> {
    let chords = |e: &Element| {
        let points = e.piece.points(SAGITTA_MM);
        points.windows(2).map(|w| (w[0], w[1])).collect::<Vec<_>>()
    };
    path.iter().flat_map(chords).collect()
}

/// The largest remainder of the places that the tool touches, by its size.
pub(crate) fn largest(remainders: &[Remainder]) -> Option<Remainder> {
    let reached = remainders.iter().filter(|r| r.reached);
    reached.copied().max_by(|a, b| a.left_mm.abs().total_cmp(&b.left_mm.abs()))
}
