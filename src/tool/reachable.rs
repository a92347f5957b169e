//! What a tool can cut of an outline: the rest is replaced by what stays in front of its edges.
//!
//! Towards the chuck a surface may fall no steeper than the trailing edge allows: from the first
//! steeper place on, the edge's own line stays, down to where it meets the outline again. Surfaces
//! that face the tailstock more steeply than the leading edge are bounded by its line in the same
//! way, from the other end. A concave arc below the nose's radius is left out: the lines beside it
//! run on into a corner, which the nose rounds by itself.

use glam::DVec2;

use crate::nose::ToolGeometry;
use crate::outline::{Arc, Outline, Piece, Side, meetings};

/// What of a part a tool cannot reach, and leaves.
#[derive(Clone, Debug)]
pub(crate) struct Reachable {
    /// The outline that it can cut.
    pub outline: Outline,
    /// What it leaves out.
    pub left_out: Vec<LeftOut>,
}

/// A place that is not cut as drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LeftOut {
    /// Why.
    pub why: OutOfReach,
    /// Z between which it lies, mm.
    pub z_mm: (f64, f64),
    /// Angle of the steepest normal there, rad, or radius of the arc, mm.
    pub value: f64,
}

/// Why a place is not cut as drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum OutOfReach {
    /// It falls towards the chuck more steeply than the trailing edge.
    TrailingEdge,
    /// It faces the tailstock more steeply than the leading edge.
    LeadingEdge,
    /// A concave arc below the nose's radius.
    NoseRadius,
}

/// Angle by which a limit may be passed for rounding, rad.
const ROUNDING_RAD: f64 = 1e-9;
/// Share of a piece by which the tangent place is moved past the start of an edge's line.
const ROUNDING_SHARE: f64 = 1e-9;
/// Length below which a piece is none, mm.
const NO_LENGTH_MM: f64 = 1e-7;

impl Reachable {
    /// Of a shaft's outline; `geometry` is that of a tool for shafts.
    pub(crate) fn of(outline: &Outline, geometry: &ToolGeometry) -> Self {
        let (low, high) = geometry.range_rad();
        let mut left_out = Vec::new();
        let falling = shadowed(&outline.pieces, low, (OutOfReach::TrailingEdge, &mut left_out));
        let before = left_out.len();
        let mirrored = mirrored(&falling);
        let facing = shadowed(&mirrored, -high, (OutOfReach::LeadingEdge, &mut left_out));
        for out in &mut left_out[before..] {
            (out.z_mm, out.value) = ((-out.z_mm.1, -out.z_mm.0), -out.value);
        }
        let pieces = without_small_arcs(self::mirrored(&facing), geometry.nose_radius_mm, &mut left_out);
        Self { outline: Outline { pieces, side: Side::External }, left_out }
    }
}

/// The pieces mirrored in Z, in the direction of an outline.
fn mirrored(pieces: &[Piece]) -> Vec<Piece> {
    let flip = |p: DVec2| DVec2::new(p.x, -p.y);
    let one = |p: &Piece| Piece {
        from: flip(p.to),
        to: flip(p.from),
        from_rad: -p.to_rad,
        to_rad: -p.from_rad,
        arc: p.arc.map(|arc| Arc { centre: flip(arc.centre), ..arc }),
    };
    pieces.iter().rev().map(one).collect()
}

/// The outline with the line of an edge, whose normal is `low`, where it falls more steeply towards
/// the chuck. The pieces are taken from the tailstock on.
fn shadowed(pieces: &[Piece], low: f64, (why, left_out): (OutOfReach, &mut Vec<LeftOut>)) -> Vec<Piece> {
    let mut waiting: Vec<Piece> = pieces.to_vec();
    let mut kept: Vec<Piece> = Vec::new();
    while let Some(piece) = waiting.pop() {
        let Some(share) = steep_from(&piece, low) else {
            kept.push(piece);
            continue;
        };
        if share < 1.0 {
            kept.push(piece.between(share, 1.0));
        }
        let start = if share < 1.0 { piece.at(share) } else { piece.to };
        if share > ROUNDING_SHARE {
            waiting.push(piece.between(0.0, share));
        }
        let (end, steepest) = edge_line(start, low, &mut waiting);
        if start.distance(end) > NO_LENGTH_MM {
            kept.push(Piece::line(end, start, low));
        }
        left_out.push(LeftOut { why, z_mm: (end.y, start.y), value: steepest });
    }
    kept.reverse();
    kept
}

/// The share of a piece, taken from its end, at which it first falls more steeply than `low`; none
/// where it does not.
fn steep_from(piece: &Piece, low: f64) -> Option<f64> {
    let steep = |a: f64| a < low - ROUNDING_RAD;
    if steep(piece.to_rad) {
        return Some(1.0);
    }
    // along a convex arc, taken from its end, the normal falls
    steep(piece.from_rad).then(|| (low - piece.from_rad) / (piece.to_rad - piece.from_rad))
}

/// The end of an edge's line from `start`: where it meets the outline that waits, which is cut
/// there, or where the outline ends; and the steepest normal on the way.
fn edge_line(start: DVec2, low: f64, waiting: &mut Vec<Piece>) -> (DVec2, f64) {
    let along = -DVec2::from_angle(low).perp();
    let ray = Piece::line(start, start + along, low);
    let mut steepest = low;
    while let Some(piece) = waiting.pop() {
        steepest = steepest.min(piece.from_rad.min(piece.to_rad));
        let on = |at: &DVec2| {
            (-ROUNDING_SHARE..=1.0 + ROUNDING_SHARE).contains(&piece.share_of(*at))
                && (*at - start).dot(along) > NO_LENGTH_MM
        };
        let found = meetings(&ray, &piece).into_iter().filter(on);
        let Some(at) = found.max_by(|a, b| piece.share_of(*a).total_cmp(&piece.share_of(*b))) else {
            if waiting.is_empty() {
                return (at_end(start, along, piece.from), steepest);
            }
            continue;
        };
        let rest = piece.between(0.0, piece.share_of(at).clamp(0.0, 1.0));
        if rest.length_mm() > NO_LENGTH_MM {
            waiting.push(Piece { to: at, ..rest });
        }
        return (at, steepest);
    }
    (start, steepest)
}

/// Where a line from `start` passes the Z of the outline's end, or the axis before it.
fn at_end(start: DVec2, along: DVec2, end: DVec2) -> DVec2 {
    let to_z = if along.y.abs() > 1e-12 { ((end.y - start.y) / along.y).max(0.0) } else { 0.0 };
    let to_axis = if along.x < -1e-12 { -start.x / along.x } else { f64::INFINITY };
    start + along * to_z.min(to_axis)
}

/// The pieces without concave arcs below the nose's radius: those beside them meet in a corner.
fn without_small_arcs(pieces: Vec<Piece>, radius_mm: f64, left_out: &mut Vec<LeftOut>) -> Vec<Piece> {
    let mut kept: Vec<Piece> = Vec::with_capacity(pieces.len());
    let mut open: Option<Piece> = None;
    for piece in pieces {
        let is_small =
            piece.arc.is_some_and(|arc| arc.radius_mm < 0.0 && -arc.radius_mm < radius_mm - NO_LENGTH_MM);
        if is_small && !kept.is_empty() && open.is_none() {
            open = Some(piece);
            continue;
        }
        match open.take().zip(kept.last().copied()) {
            None => kept.push(piece),
            Some((arc, before)) => {
                let near = |at: &DVec2| at.distance(arc.at(0.5));
                let corner = meetings(&before, &piece).into_iter().min_by(|a, b| near(a).total_cmp(&near(b)));
                // carriers that do not meet keep their arc: the path is refused there with its
                // place
                let Some(at) = corner.filter(|at| near(at) < 4.0 * arc.length_mm()) else {
                    kept.extend([arc, piece]);
                    continue;
                };
                let count = kept.len();
                kept[count - 1] = ended(&before, at);
                kept.push(begun(&piece, at));
                let z_mm = (arc.from.y.min(arc.to.y), arc.from.y.max(arc.to.y));
                let value = arc.arc.map_or(0.0, |a| -a.radius_mm);
                left_out.push(LeftOut { why: OutOfReach::NoseRadius, z_mm, value });
            }
        }
    }
    kept.extend(open);
    kept
}

/// A piece that goes on to a point of its carrier.
fn ended(piece: &Piece, at: DVec2) -> Piece {
    Piece { to: at, ..piece.between(0.0, piece.share_of(at)) }
}

/// A piece that begins at a point of its carrier.
fn begun(piece: &Piece, at: DVec2) -> Piece {
    Piece { from: at, ..piece.between(piece.share_of(at), 1.0) }
}
