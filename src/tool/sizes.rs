//! What is left as changes of sizes: diameters, lengths of faces, cones, arcs and corners.
//!
//! With c = cos a and s = sin a a remainder e changes a diameter by 2e, a face by e along Z, a cone
//! by 2e/c on the diameter at a fixed Z and by e/s along Z. An arc changes by the least-squares
//! circle through the displaced points: e ≈ v·n ± Δr, + for a convex arc. A corner moves to where
//! the displaced surfaces intersect: v·n1 = e1 and v·n2 = e2.

use glam::DVec2;
use nalgebra::Vector3;

use super::left::Remainder;
use crate::numerics::normal_equations::NormalEquations;
use crate::outline::{Outline, Piece};

/// What a piece of an outline is on a drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Kind {
    /// A cylinder.
    Diameter,
    /// An end face or a shoulder.
    Face,
    /// A cone.
    Cone,
    /// A convex arc.
    ConvexArc,
    /// A concave arc.
    ConcaveArc,
}

/// How a piece differs from the drawing; a value that does not apply is absent.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub(crate) struct PieceChange {
    /// What it is.
    pub kind: Kind,
    /// Z of its ends, mm.
    pub z_mm: [f64; 2],
    /// Diameters at its ends, mm.
    pub diameter_mm: [f64; 2],
    /// Least remainder along the normal where the tool touches, µm.
    pub least_left_um: f64,
    /// Largest remainder, µm.
    pub most_left_um: f64,
    /// Change of the diameter (of a cone at a fixed Z), µm.
    pub diameter_um: Option<f64>,
    /// Change along Z (of a cone at a fixed diameter), µm.
    pub z_um: Option<f64>,
    /// Change of an arc's radius, µm.
    pub radius_um: Option<f64>,
    /// Movement of an arc's centre in X (radial) and Z, µm.
    pub centre_um: Option<[f64; 2]>,
    /// Largest distance of the displaced points from the least-squares circle, µm.
    pub form_um: Option<f64>,
}

/// How a corner between two pieces moves.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub(crate) struct CornerChange {
    /// Z on the drawing, mm.
    pub z_mm: f64,
    /// Diameter on the drawing, mm.
    pub diameter_mm: f64,
    /// Change of the diameter, µm.
    pub diameter_um: f64,
    /// Change of Z, µm.
    pub z_um: f64,
}

/// Sine or cosine below which a surface is parallel to an axis: 0.1 nm on 100 mm.
const PARALLEL: f64 = 1e-9;
/// Turn below which there is no corner, rad.
const TANGENT_RAD: f64 = 1e-6;

/// The changes of all pieces that the tool touches, and of the corners between them.
pub(crate) fn changes(outline: &Outline, left: &[Remainder]) -> (Vec<PieceChange>, Vec<CornerChange>) {
    let of = |i: usize| left.iter().filter(move |r| r.source == i && r.reached);
    let pieces = outline.pieces.iter().enumerate();
    let changed =
        pieces.filter_map(|(i, piece)| change(piece, &of(i).copied().collect::<Vec<_>>())).collect();
    let corner = |i: usize| {
        let (a, b) = (&outline.pieces[i], &outline.pieces[i + 1]);
        let (one, other) = (of(i).next_back()?.left_mm, of(i + 1).next()?.left_mm);
        corner_change((a.to, a.to_rad, b.from_rad), one, other)
    };
    (changed, (0..outline.pieces.len().saturating_sub(1)).filter_map(corner).collect())
}

fn change(piece: &Piece, left: &[Remainder]) -> Option<PieceChange> {
    let (cos, sin) = (piece.from_rad.cos(), piece.from_rad.sin());
    let kind = match piece.arc {
        Some(arc) if arc.radius_mm > 0.0 => Kind::ConvexArc,
        Some(_) => Kind::ConcaveArc,
        None if sin.abs() < PARALLEL => Kind::Diameter,
        None if cos.abs() < PARALLEL => Kind::Face,
        None => Kind::Cone,
    };
    let sizes = || left.iter().map(|r| 1e3 * r.left_mm);
    let (least, most) = sizes().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), v| (l.min(v), m.max(v)));
    let mean = sizes().sum::<f64>() / left.len() as f64;
    let circle = piece.arc.and_then(|arc| circle(left, arc.radius_mm.signum()));
    (!left.is_empty()).then(|| PieceChange {
        kind,
        z_mm: [piece.from.y, piece.to.y],
        diameter_mm: [2.0 * piece.from.x, 2.0 * piece.to.x],
        least_left_um: least,
        most_left_um: most,
        diameter_um: matches!(kind, Kind::Diameter | Kind::Cone).then(|| 2.0 * mean / cos),
        z_um: matches!(kind, Kind::Face | Kind::Cone).then(|| mean / sin),
        radius_um: circle.map(|c| c.0[2]),
        centre_um: circle.map(|c| [c.0[0], c.0[1]]),
        form_um: circle.map(|c| c.1),
    })
}

/// Centre's movement and change of the radius, µm, of the least-squares circle through displaced
/// points, and their largest distance from it; none of fewer than three places.
fn circle(left: &[Remainder], sign: f64) -> Option<(Vector3<f64>, f64)> {
    let terms = |r: &Remainder| Vector3::new(r.a_rad.cos(), r.a_rad.sin(), sign);
    let mut sums = NormalEquations::<3>::new();
    left.iter().for_each(|r| sums.add(terms(r), 1e3 * r.left_mm, 1.0));
    let found = (left.len() >= 3).then(|| sums.by_cholesky()).flatten()?;
    let away = left.iter().map(|r| (1e3 * r.left_mm - terms(r).dot(&found)).abs()).fold(0.0, f64::max);
    Some((found, away))
}

fn corner_change((at, a, b): (DVec2, f64, f64), one: f64, other: f64) -> Option<CornerChange> {
    let (n, m) = (DVec2::from_angle(a), DVec2::from_angle(b));
    let sine = n.perp_dot(m);
    (sine.abs() > TANGENT_RAD).then(|| {
        let by = (n.perp() * other - m.perp() * one) / sine;
        CornerChange { z_mm: at.y, diameter_mm: 2.0 * at.x, diameter_um: 2e3 * by.x, z_um: 1e3 * by.y }
    })
}
