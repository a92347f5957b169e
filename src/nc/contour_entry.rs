//! How a cut along lines and arcs is entered and left.

use glam::DVec2;

use crate::outline::Piece;

/// Beyond this share of Z in its normal a piece is entered and left along Z.
const FACE: f64 = 0.7;

/// How a cut is entered.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    /// Where the feed along it begins.
    pub(super) from: DVec2,
    /// Where it ends, on the first piece or before it.
    pub(super) to: DVec2,
}

/// Direction of the cut at the ends of a piece, from its chord or, on an arc, at right angles to
/// the normal.
fn way(piece: &Piece, a: f64) -> DVec2 {
    let along = DVec2::from_angle(a).perp();
    along * (piece.to - piece.from).dot(along).signum()
}

/// Along the first piece where that leads in from beyond the end face, else along its normal, onto
/// its line `before_mm` before its first point.
pub(super) fn entry(first: &Piece, lead_mm: f64, before_mm: f64) -> Entry {
    let (along, n) = (way(first, first.from_rad), DVec2::from_angle(first.from_rad));
    let back = first.from - lead_mm * along;
    if back.y - first.from.y > FACE * lead_mm && back.x >= 0.0 {
        return Entry { from: back, to: first.from };
    }
    let to = first.from - before_mm * along;
    Entry { from: to + lead_mm * n, to }
}

/// Where a cut that ends on a face is left to, along Z; others are left radially.
pub(super) fn exit(last: &Piece, lead_mm: f64) -> Option<DVec2> {
    let n = DVec2::from_angle(last.to_rad);
    (n.y > FACE).then(|| last.to + DVec2::new(0.0, lead_mm))
}
