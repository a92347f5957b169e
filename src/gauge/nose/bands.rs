//! The pixels of a band along the contour, by calipers of the edges and sectors of the nose.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

use super::line::EdgeLine;
use super::path::Path;
use crate::frame::FrameView;
use crate::gauge::ring::edge_pixels::{Band, EdgePixel};

/// A stretch of an edge in calipers.
#[derive(Clone, Copy, Debug)]
pub(in crate::gauge) struct Calipers {
    /// Place along the line of its first caliper's beginning, px from the line's `at`.
    pub(in crate::gauge) from: f64,
    /// Length of a caliper, px.
    pub(in crate::gauge) length: f64,
    /// Their number.
    pub(in crate::gauge) count: usize,
}

impl Calipers {
    /// Place along the line of the middle of caliper k, px.
    pub(in crate::gauge) fn middle(&self, k: usize) -> f64 {
        self.from + (k as f64 + 0.5) * self.length
    }
}

/// The band's order: calipers of the first edge, sectors of the nose, calipers of the second edge.
pub(super) struct BandPlan<'a> {
    /// The contour that it follows.
    pub(super) path: &'a Path,
    /// Calipers of both edges.
    pub(super) calipers: [Calipers; 2],
    /// Half width towards the shadow and towards the light, px.
    pub(super) half: (f64, f64),
}

/// Collects the pixels whose centres lie within the band.
pub(super) fn collect(view: &FrameView<'_>, plan: &BandPlan<'_>) -> Band {
    let BandPlan { path, calipers, .. } = plan;
    let reach = |k: usize| {
        let c = calipers[k];
        let line = &path.lines[k];
        let at = |s: f64| (line.at + line.along() * s - path.centre).length();
        at(c.from).max(at(c.from + c.length * c.count as f64))
    };
    let unit_px = reach(0).max(reach(1)).max(path.nominal_px);
    let mut sectors = vec![Vec::new(); calipers[0].count + path.radii.len() + calipers[1].count];
    let pixel = |value: f64, distance: f64, normal: DVec2, at: DVec2| {
        let place = (at - path.centre) / unit_px;
        EdgePixel { value, distance, cos: normal.x, sin: normal.y, x: place.x, y: place.y }
    };
    for (k, first) in [(0, 0), (1, calipers[0].count + path.radii.len())] {
        let normal = path.lines[k].normal;
        along_line(view, &path.lines[k], &calipers[k], plan.half, |caliper, distance, at, value| {
            sectors[first + caliper].push(pixel(value, distance, normal, at));
        });
    }
    let first = calipers[0].count;
    around_nose(view, plan, |sector, distance, normal, at, value| {
        sectors[first + sector].push(pixel(value, distance, normal, at));
    });
    Band { sectors, turned: false, origin: path.centre, unit_px }
}

/// The frame's value at a place of whole pixels.
pub(in crate::gauge) fn value_at(view: &FrameView<'_>, column: isize, row: isize) -> Option<f64> {
    if column < 0 || row < 0 {
        return None;
    }
    view.get(row as usize, column as usize).map(f64::from)
}

/// Pixels along a line: its main direction pixel by pixel, across it those within the band.
pub(in crate::gauge) fn along_line(
    view: &FrameView<'_>,
    line: &EdgeLine,
    calipers: &Calipers,
    (dark, light): (f64, f64),
    mut push: impl FnMut(usize, f64, DVec2, f64),
) {
    let (n, along, half) = (line.normal, line.along(), dark.max(light));
    let ends = [0.0, calipers.count as f64].map(|k| line.at + along * (calipers.from + k * calipers.length));
    let by_rows = n.x.abs() >= n.y.abs();
    let major = |p: DVec2| if by_rows { -p.y } else { p.x };
    let (low, high) = (major(ends[0]).min(major(ends[1])), major(ends[0]).max(major(ends[1])));
    let width = half / n.x.abs().max(n.y.abs());
    for i in (low - half).floor() as isize..=(high + half).ceil() as isize {
        let at_major = i as f64;
        let middle = if by_rows {
            line.at.x - n.y * (-at_major - line.at.y) / n.x
        } else {
            -(line.at.y - n.x * (at_major - line.at.x) / n.y)
        };
        for j in (middle - width).ceil() as isize..=(middle + width).floor() as isize {
            let (column, row) = if by_rows { (j, i) } else { (i, j) };
            let at = DVec2::new(column as f64, -row as f64);
            let (distance, place) = (line.distance(at), along.dot(at - line.at) - calipers.from);
            let caliper = (place / calipers.length).floor();
            if distance < -dark || distance > light || caliper < 0.0 || caliper >= calipers.count as f64 {
                continue;
            }
            if let Some(value) = value_at(view, column, row) {
                push(caliper as usize, distance, at, value);
            }
        }
    }
}

/// Pixels around the nose, each with the normal of the contour in its direction.
fn around_nose(
    view: &FrameView<'_>,
    plan: &BandPlan<'_>,
    mut push: impl FnMut(usize, f64, DVec2, DVec2, f64),
) {
    let (path, (dark, light)) = (plan.path, plan.half);
    let (least, most) = path.radii.iter().fold((f64::INFINITY, 0.0_f64), |(l, m), r| (l.min(*r), m.max(*r)));
    let (inner, outer) = ((least - 2.0 * dark).max(0.0), most + 2.0 * light);
    let (centre, step) = (path.centre, path.step_rad());
    for row in (-centre.y - outer).floor() as isize..=(-centre.y + outer).ceil() as isize {
        for column in (centre.x - outer).floor() as isize..=(centre.x + outer).ceil() as isize {
            let at = DVec2::new(column as f64, -row as f64);
            let arm = at - centre;
            let r = arm.length();
            if r < inner || r > outer {
                continue;
            }
            let turn = (arm.to_angle() - path.from_rad + PI).rem_euclid(TAU) - PI;
            let sector = (turn / step).floor();
            if sector < 0.0 || sector >= path.radii.len() as f64 {
                continue;
            }
            let (radius, slope) = path.radius(turn);
            // by how much the contour leans against the circle: its normal is the arm turned back
            let tan = slope / radius;
            let cos = (1.0 + tan * tan).sqrt().recip();
            let distance = (r - radius) * cos;
            if distance < -dark || distance > light {
                continue;
            }
            if let Some(value) = value_at(view, column, row) {
                let normal = DVec2::new(cos, -tan * cos).rotate(arm / r);
                push(sector as usize, distance, normal, at, value);
            }
        }
    }
}
