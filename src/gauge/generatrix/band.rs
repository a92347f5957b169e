//! The band along one piece, in calipers.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

use super::expected::{ExpectedPiece, Placement};
use super::limits::GeneratrixLimits;
use crate::frame::FrameView;
use crate::gauge::nose::bands::{Calipers, along_line, value_at};
use crate::gauge::nose::line::EdgeLine;
use crate::gauge::ring::edge_pixels::EdgePixel;

/// An arc in sectors, px.
#[derive(Clone, Copy, Debug)]
pub(super) struct ArcBand {
    /// Centre (column, −row).
    pub(super) centre: DVec2,
    /// Radius.
    pub(super) radius: f64,
    /// +1 where the light lies outside of the circle, −1 where inside.
    pub(super) outwards: f64,
    /// Direction from the centre at which it begins, rad, and its sweep, above 0.
    pub(super) from_rad: f64,
    pub(super) sweep_rad: f64,
    /// Its sectors.
    pub(super) count: usize,
}

impl ArcBand {
    /// Direction of the middle of a sector, rad.
    pub(super) fn direction_rad(&self, k: usize) -> f64 {
        self.from_rad + self.sweep_rad * (k as f64 + 0.5) / self.count as f64
    }
}

/// What a band follows.
#[derive(Clone, Copy, Debug)]
pub(super) enum Shape {
    /// A line in calipers.
    Line(EdgeLine, Calipers),
    /// An arc in sectors.
    Arc(ArcBand),
}

impl Shape {
    /// Of an expected piece.
    pub(super) fn of(expected: &ExpectedPiece, at: &Placement) -> Self {
        let (piece, half) = (expected.piece, expected.half);
        let length = piece.length_mm() / at.mm_per_px;
        let count = (length / GeneratrixLimits::get().caliper_px).floor().max(1.0) as usize;
        let [from, to] = [piece.from, piece.to].map(|p| at.place(p, half));
        let direction = |a: f64| Placement::direction(DVec2::from_angle(a), half);
        let Some(arc) = piece.arc else {
            let line = EdgeLine::coarse(direction(piece.from_rad).normalize(), 0.5 * (from + to));
            let calipers = Calipers { from: -0.5 * length, length: length / count as f64, count };
            return Self::Line(line, calipers);
        };
        let outwards = arc.radius_mm.signum();
        // as seen: counter-clockwise, whichever way the piece runs
        let ends = [piece.from_rad, piece.to_rad].map(|a| (outwards * direction(a)).to_angle());
        let turn = (ends[1] - ends[0] + PI).rem_euclid(TAU) - PI;
        let from_rad = if turn < 0.0 { ends[1] } else { ends[0] };
        Self::Arc(ArcBand {
            centre: at.place(arc.centre, half),
            radius: arc.radius_mm.abs() / at.mm_per_px,
            outwards,
            from_rad,
            sweep_rad: turn.abs(),
            count,
        })
    }

    /// Its calipers.
    pub(super) fn count(&self) -> usize {
        match self {
            Self::Line(_, calipers) => calipers.count,
            Self::Arc(arc) => arc.count,
        }
    }

    /// Its middle, (column, −row).
    pub(super) fn middle(&self) -> DVec2 {
        match self {
            Self::Line(line, _) => line.at,
            Self::Arc(a) => a.centre + a.radius * DVec2::from_angle(a.from_rad + 0.5 * a.sweep_rad),
        }
    }

    /// Its pixels by caliper: within `dark` and `light` px of it, places counted from `origin` in
    /// units of `unit_px`.
    pub(super) fn pixels(
        &self,
        view: &FrameView<'_>,
        (dark, light): (f64, f64),
        (origin, unit_px): (DVec2, f64),
    ) -> Vec<Vec<EdgePixel>> {
        let mut sectors = vec![Vec::new(); self.count()];
        let mut push = |sector: usize, distance: f64, normal: DVec2, at: DVec2, value: f64| {
            let place = (at - origin) / unit_px;
            let pixel = EdgePixel { value, distance, cos: normal.x, sin: normal.y, x: place.x, y: place.y };
            sectors[sector].push(pixel);
        };
        match self {
            Self::Line(line, calipers) => {
                along_line(view, line, calipers, (dark, light), |k, distance, at, value| {
                    push(k, distance, line.normal, at, value);
                });
            }
            Self::Arc(arc) => along_arc(view, arc, (dark, light), push),
        }
        sectors
    }
}

/// Pixels along an arc, within the box about it.
fn along_arc(
    view: &FrameView<'_>,
    arc: &ArcBand,
    (dark, light): (f64, f64),
    mut push: impl FnMut(usize, f64, DVec2, DVec2, f64),
) {
    let reach = dark.max(light) + 1.0;
    let places = (0..=arc.count)
        .map(|k| arc.from_rad + arc.sweep_rad * k as f64 / arc.count as f64)
        .map(|turn| arc.centre + arc.radius * DVec2::from_angle(turn));
    let (low, high) = places.fold((DVec2::MAX, DVec2::MIN), |(l, h), p| (l.min(p), h.max(p)));
    let (low, high) = (low - reach, high + reach);
    for row in (-high.y).floor() as isize..=(-low.y).ceil() as isize {
        for column in low.x.floor() as isize..=high.x.ceil() as isize {
            let at = DVec2::new(column as f64, -row as f64);
            let arm = at - arc.centre;
            let r = arm.length();
            let distance = arc.outwards * (r - arc.radius);
            if distance < -dark || distance > light {
                continue;
            }
            let turn = (arm.to_angle() - arc.from_rad).rem_euclid(TAU);
            let sector = (turn / arc.sweep_rad * arc.count as f64).floor();
            if sector >= arc.count as f64 {
                continue;
            }
            if let Some(value) = value_at(view, column, row) {
                push(sector as usize, distance, arc.outwards * arm / r, at, value);
            }
        }
    }
}
