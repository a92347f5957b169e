//! Pieces as they are expected, and where they lie in the image.

use glam::DVec2;

use crate::outline::Piece;

/// One half of a silhouette.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HalfSilhouette {
    /// Above the axis in the image.
    Above,
    /// Below it.
    Below,
}

impl HalfSilhouette {
    /// +1 where X points up in the image.
    pub(super) fn sign(self) -> f64 {
        match self {
            Self::Above => 1.0,
            Self::Below => -1.0,
        }
    }
}

/// A line or an arc of the outline, (X, Z) in mm with the normal away from the material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ExpectedPiece {
    /// The piece.
    pub piece: Piece,
    /// The half in which it is measured.
    pub half: HalfSilhouette,
}

/// Where the axis lies in the image: row = axis_row ∓ X/p, column = zero_column + Z/p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placement {
    /// Row of the axis, px; exact only for sizes that a single half gives.
    pub axis_row_px: f64,
    /// Column of Z = 0, px.
    pub zero_column_px: f64,
    /// Size of a pixel in the object, mm.
    pub mm_per_px: f64,
}

impl Placement {
    /// The place (column, −row) of a point (X, Z), px.
    pub(super) fn place(&self, point: DVec2, half: HalfSilhouette) -> DVec2 {
        let x = half.sign() * point.x / self.mm_per_px;
        DVec2::new(self.zero_column_px + point.y / self.mm_per_px, x - self.axis_row_px)
    }

    /// The direction in the image of a direction (X, Z).
    pub(super) fn direction(direction: DVec2, half: HalfSilhouette) -> DVec2 {
        DVec2::new(direction.y, half.sign() * direction.x)
    }

    /// The point (X, Z) of a place, mm: the inverse of [`Self::place`].
    pub(super) fn point(&self, place: DVec2, half: HalfSilhouette) -> DVec2 {
        let x = half.sign() * (place.y + self.axis_row_px);
        DVec2::new(x, place.x - self.zero_column_px) * self.mm_per_px
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_return_from_the_image_and_x_points_away_from_the_axis() {
        let at = Placement { axis_row_px: 511.5, zero_column_px: 30.0, mm_per_px: 0.05 };
        let p = DVec2::new(7.0, 11.0);
        for half in [HalfSilhouette::Above, HalfSilhouette::Below] {
            assert!(at.point(at.place(p, half), half).distance(p) < 1e-12);
        }
        // row 511.5 − 140 above, + 140 below; column 30 + 220
        assert!(at.place(p, HalfSilhouette::Above).distance(DVec2::new(250.0, -371.5)) < 1e-9);
        assert!(at.place(p, HalfSilhouette::Below).distance(DVec2::new(250.0, -651.5)) < 1e-9);
        assert_eq!(Placement::direction(DVec2::X, HalfSilhouette::Below), DVec2::NEG_Y);
    }
}
