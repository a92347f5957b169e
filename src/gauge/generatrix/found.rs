//! Pieces as found, in px, and in mm of the part.

use glam::DVec2;

use super::expected::{HalfSilhouette, Placement};

/// A line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FoundLine {
    /// The half in which it was measured.
    pub half: HalfSilhouette,
    /// A place on it, (column, −row) in px.
    pub at_px: DVec2,
    /// Its unit normal towards the light.
    pub normal: DVec2,
    /// Standard uncertainty of its offset along the normal, px.
    pub u_px: f64,
    /// Calipers that are not on it.
    pub left_out: usize,
}

/// An arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FoundArc {
    /// The half in which it was measured.
    pub half: HalfSilhouette,
    /// Centre of its least-squares circle, (column, −row) in px.
    pub centre_px: DVec2,
    /// The circle's radius, px.
    pub radius_px: f64,
    /// Whether it is convex.
    pub convex: bool,
    /// Standard uncertainty of the radius by the calipers' own noise, px.
    pub u_px: f64,
    /// Calipers that are not on it.
    pub left_out: usize,
}

/// A piece of the silhouette.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum FoundPiece {
    /// A line.
    Line(FoundLine),
    /// An arc.
    Arc(FoundArc),
}

impl FoundLine {
    /// n and d of the line n·(X, Z) = d, mm; `offset_mm` lies between the image and the edge,
    /// towards the light.
    pub(crate) fn in_mm(&self, at: &Placement, offset_mm: f64) -> (DVec2, f64) {
        let normal = DVec2::new(self.half.sign() * self.normal.y, self.normal.x);
        (normal, normal.dot(at.point(self.at_px, self.half)) + offset_mm)
    }
}

impl FoundArc {
    /// Centre (X, Z) and radius, mm; `offset_mm` as of a line.
    pub(crate) fn in_mm(&self, at: &Placement, offset_mm: f64) -> (DVec2, f64) {
        let outwards = if self.convex { 1.0 } else { -1.0 };
        (at.point(self.centre_px, self.half), at.mm_per_px * self.radius_px + outwards * offset_mm)
    }
}

impl FoundPiece {
    /// The line, where it is one.
    pub(crate) fn line(&self) -> Option<&FoundLine> {
        match self {
            Self::Line(line) => Some(line),
            Self::Arc(_) => None,
        }
    }

    /// The arc, where it is one.
    pub(crate) fn arc(&self) -> Option<&FoundArc> {
        match self {
            Self::Arc(arc) => Some(arc),
            Self::Line(_) => None,
        }
    }

    /// Calipers that are not on it.
    pub(crate) fn left_out(&self) -> usize {
        match self {
            Self::Line(line) => line.left_out,
            Self::Arc(arc) => arc.left_out,
        }
    }

    /// Standard uncertainty of a line's offset or of an arc's radius by noise, px.
    pub(crate) fn u_px(&self) -> f64 {
        match self {
            Self::Line(line) => line.u_px,
            Self::Arc(arc) => arc.u_px,
        }
    }
}
