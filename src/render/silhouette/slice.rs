//! Slices with threads, feed marks, flats and keyways.
//!
//! A helix adds a height that is piecewise quadratic in θ; a flat limits p·n ≤ d; a keyway
//! removes |p·t| < w/2 with p·n > b. The largest r(θ)cos(θ + φ) of the remainder lies inside a
//! piece on which r is smooth, at the rim of a cut, or where two cuts intersect: segments are
//! divided where pieces of a helix meet and where cuts begin, rims are found by bisection, and
//! intersections of straight cuts are evaluated one by one. The floor of a keyway and the middle of
//! a flat are never the highest point: the tangent bridges them.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

use super::features::{helix_height, piece_at, turn};
use super::outline::Outline;
use super::segments::{Direction, Rows, Segment, lobe_derivatives};
use crate::shaft::{Flat, Helix, Keyway};

/// Bisection steps for the rim of a cut on a piece of 0.025 rad: 1e-15 rad.
const HALVINGS: usize = 44;

/// Rounding error by which a point may lie beyond a cut, relative to the radius.
const ROUNDING: f64 = 1e-12;

impl Outline {
    /// Radius of the slice at z in body direction θ (radians), mm: the outermost point where a
    /// keyway leaves two. Eccentricity moves the axis and is not included.
    pub(crate) fn radius_mm(&self, z_mm: f64, theta: f64) -> f64 {
        Slice::at(self, z_mm).cut(theta, self.uncut_radius_mm(z_mm, theta))
    }

    /// [`Self::radius_mm`] before flats and keyways are cut.
    pub(super) fn uncut_radius_mm(&self, z_mm: f64, theta: f64) -> f64 {
        let lobes: f64 = self.shaft.lobes.iter().map(|l| lobe_derivatives(l, theta)[0]).sum();
        let helices = &self.shaft.features.helices;
        self.mean_radius_mm(z_mm)
            + lobes
            + Rows::at(self.shaft.texture.as_ref(), z_mm).height(theta)
            + helices.iter().map(|h| helix_height(h, z_mm, theta)).sum::<f64>()
    }
}

/// One slice with the features cut into it.
pub(super) struct Slice<'a> {
    outline: &'a Outline,
    z_mm: f64,
    helices: Vec<&'a Helix>,
    flats: Vec<(&'a Flat, DVec2)>,
    keyways: Vec<(&'a Keyway, DVec2)>,
}

impl<'a> Slice<'a> {
    pub(super) fn at(outline: &'a Outline, z_mm: f64) -> Self {
        let f = &outline.shaft.features;
        let normal = |degrees: f64| DVec2::from_angle(degrees.to_radians());
        Self {
            outline,
            z_mm,
            helices: f.helices.iter().filter(|h| (h.from_mm..=h.to_mm).contains(&z_mm)).collect(),
            flats: f
                .flats
                .iter()
                .filter(|f| (f.from_mm..=f.to_mm).contains(&z_mm))
                .map(|f| (f, normal(f.angle_deg)))
                .collect(),
            keyways: f
                .keyways
                .iter()
                .filter(|k| (k.from_mm..=k.to_mm).contains(&z_mm))
                .map(|k| (k, normal(k.angle_deg)))
                .collect(),
        }
    }

    /// The radius at θ after flats and keyways are cut into a body of radius `uncut_mm` there.
    pub(super) fn cut(&self, theta: f64, uncut_mm: f64) -> f64 {
        let direction = DVec2::from_angle(theta);
        let mut radius = uncut_mm;
        for (flat, normal) in &self.flats {
            let cos = direction.dot(*normal);
            if radius * cos > flat.distance_mm {
                radius = flat.distance_mm / cos;
            }
        }
        for (keyway, normal) in &self.keyways {
            let (cos, sin) = (direction.dot(*normal), direction.perp_dot(*normal));
            if radius * cos > keyway.floor_mm && (radius * sin).abs() < 0.5 * keyway.width_mm {
                radius = keyway.floor_mm / cos;
            }
        }
        radius
    }

    /// Largest x of the slice at depth `y`, for a point (x, y) of its uncut boundary, with cuts
    /// turned by `angle` (radians).
    pub(super) fn cut_along_x(&self, mut point: DVec2, angle: f64) -> f64 {
        let turned = DVec2::from_angle(angle);
        for (flat, normal) in &self.flats {
            let n = turned.rotate(*normal);
            if point.dot(n) > flat.distance_mm && n.x != 0.0 {
                point.x = (flat.distance_mm - n.y * point.y) / n.x;
            }
        }
        for (keyway, normal) in &self.keyways {
            let n = turned.rotate(*normal);
            let across = n.perp();
            let inside = |p: DVec2| p.dot(n) > keyway.floor_mm && p.dot(across).abs() < 0.5 * keyway.width_mm;
            if inside(point) {
                point.x = leave_slot(point, keyway, n);
            }
        }
        point.x
    }

    fn is_free(&self, point: DVec2) -> bool {
        let slack = ROUNDING * self.outline.mean_radii_mm().1;
        self.flats.iter().all(|(f, n)| point.dot(*n) <= f.distance_mm + slack)
            && self.keyways.iter().all(|(k, n)| {
                point.dot(*n) <= k.floor_mm + slack || point.perp_dot(*n).abs() >= 0.5 * k.width_mm - slack
            })
    }

    /// Largest height of the slice in a direction.
    pub(super) fn support(&self, direction: &Direction) -> f64 {
        let outline = self.outline;
        let mean = outline.mean_radius_mm(self.z_mm);
        let rows = Rows::at(outline.shaft.texture.as_ref(), self.z_mm);
        let mut best = self.meeting_points(direction);
        for segment in &direction.segments {
            if (mean + outline.high_mm) * segment.cos_near <= best {
                break;
            }
            let p = segment.radius(mean, segment.texture(&rows));
            best = best.max(self.on_segment(segment, &p));
        }
        best
    }

    /// Largest height on a segment, NEG_INFINITY where all of it is removed.
    fn on_segment(&self, segment: &Segment, p: &[f64; 6]) -> f64 {
        let mut best = f64::NEG_INFINITY;
        let breaks = self.breaks(segment);
        for ends in breaks.windows(2) {
            let (from, to) = (ends[0], ends[1]);
            let p = self.with_helices(segment, p, 0.5 * (from + to));
            let point = |t: f64| {
                let r = ((((p[5] * t + p[4]) * t + p[3]) * t + p[2]) * t + p[1]) * t + p[0];
                r * DVec2::from_angle(segment.middle + t)
            };
            let free = |t: f64| self.is_free(point(t));
            let (from, to) = match (free(from), free(to)) {
                (true, true) => (from, to),
                (true, false) => (from, rim(from, to, free)),
                (false, true) => (rim(to, from, free), to),
                (false, false) => continue,
            };
            best = best.max(segment.maximum_within(&p, from, to));
        }
        best
    }

    /// Places between the segment's ends where pieces of a helix meet and cuts begin,
    /// approximately, as on a round body.
    fn breaks(&self, segment: &Segment) -> Vec<f64> {
        let half = segment.half;
        let mut breaks = vec![-half, half];
        for helix in &self.helices {
            let turn = turn(helix);
            let at = |t: f64| self.z_mm / helix.pitch_mm + turn * (segment.middle + t);
            let (low, high) = (at(-half).min(at(half)), at(-half).max(at(half)));
            for piece in &helix.pieces {
                let mut phase = (low - piece.from).ceil() + piece.from;
                while phase < high {
                    breaks.push((phase - at(0.0)) / turn);
                    phase += 1.0;
                }
            }
        }
        let radius = self.outline.mean_radius_mm(self.z_mm);
        let mut about = |centre_deg: f64, spread: f64| {
            let centre = (centre_deg.to_radians() - segment.middle + PI).rem_euclid(TAU) - PI;
            breaks.extend([centre, centre - spread, centre + spread].into_iter().filter(|t| t.abs() < half));
        };
        self.flats
            .iter()
            .for_each(|(f, _)| about(f.angle_deg, (f.distance_mm / radius).clamp(-1.0, 1.0).acos()));
        self.keyways
            .iter()
            .for_each(|(k, _)| about(k.angle_deg, (0.5 * k.width_mm / radius).clamp(-1.0, 1.0).asin()));
        breaks.sort_by(f64::total_cmp);
        breaks
    }

    /// The radius with the helices' pieces that apply at `at`.
    fn with_helices(&self, segment: &Segment, p: &[f64; 6], at: f64) -> [f64; 6] {
        let mut p = *p;
        for helix in &self.helices {
            let turn = turn(helix);
            let phase = self.z_mm / helix.pitch_mm + turn * segment.middle;
            let whole = (phase + turn * at).floor();
            let piece = &helix.pieces[piece_at(helix, phase + turn * at - whole)];
            let [c0, c1, c2] = piece.height_mm;
            let w = phase - whole - piece.from;
            p[0] += c0 + w * (c1 + w * c2);
            p[1] += turn * (c1 + 2.0 * c2 * w);
            p[2] += turn * turn * c2;
        }
        p
    }

    /// Largest height of the points where two straight cuts intersect inside the body.
    fn meeting_points(&self, direction: &Direction) -> f64 {
        let walls = self.keyways.iter().flat_map(|(k, n)| {
            let across = n.perp();
            [(across, 0.5 * k.width_mm), (-across, 0.5 * k.width_mm)]
        });
        let lines: Vec<(DVec2, f64)> =
            self.flats.iter().map(|(f, n)| (*n, f.distance_mm)).chain(walls).collect();
        let mut best = f64::NEG_INFINITY;
        for (i, (n, a)) in lines.iter().enumerate() {
            for (m, b) in &lines[i + 1..] {
                let cross = n.perp_dot(*m);
                if cross.abs() < 1e-9 {
                    continue;
                }
                let point = DVec2::new(a * m.y - b * n.y, b * n.x - a * m.x) / cross;
                let theta = point.to_angle();
                let inside = point.length() <= self.outline.uncut_radius_mm(self.z_mm, theta);
                if inside && self.is_free(point) {
                    best = best.max(point.length() * (theta + direction.facing).cos());
                }
            }
        }
        best
    }
}

/// x at which a line of constant y, followed down from a point inside a slot, leaves it.
fn leave_slot(point: DVec2, keyway: &Keyway, n: DVec2) -> f64 {
    let across = n.perp();
    let floor = (n.x > 0.0).then(|| (keyway.floor_mm - n.y * point.y) / n.x);
    let wall = (across.x != 0.0).then(|| {
        let side = -0.5 * keyway.width_mm * across.x.signum();
        (side - across.y * point.y) / across.x
    });
    [floor, wall].into_iter().flatten().filter(|x| *x <= point.x).fold(f64::NEG_INFINITY, f64::max)
}

/// Boundary of the free part between `free_end`, which is free, and `other`.
fn rim(free_end: f64, other: f64, free: impl Fn(f64) -> bool) -> f64 {
    let (mut good, mut bad) = (free_end, other);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (good + bad);
        if free(middle) { good = middle } else { bad = middle }
    }
    good
}
