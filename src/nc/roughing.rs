//! Roughing from the bar in explicit blocks: facing, cuts along Z at a depth a_p, and one cut along
//! the contour that leaves the allowance of the finishing cut.
//!
//! ```text
//!   clear diameter  <- - - - rapid - - - - - -  x
//!   bar   __________________________________    | down before the end face
//!         |      ^ X        level 1  <------- - +
//!         | wall '<---------- level 2 <------ - +
//!         |     /  45° back, then out in feed
//! ```
//!
//! No cycle of the control is used: what a block cuts can be replayed and read. All rapids stay
//! outside of the bar, also where it is cut away already, so that a program that is started again
//! in the middle meets nothing. A level ends where the gauge point meets the boundary, its path
//! that leaves the allowance. Behind a collar a level is entered along the boundary's own slope,
//! from above.

use glam::DVec2;

use super::dialect::{Dialect, number};
use super::route::Workpiece;
use crate::outline::Piece;

/// What is roughed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Roughing<'a> {
    /// Path of the gauge point that leaves the allowance, from the chuck to the axis of the end
    /// face; X as a radius.
    pub boundary: &'a [Piece],
    /// Radius of the bar, mm.
    pub bar_mm: f64,
    /// Z by which the bar's end stands beyond the face that leaves the allowance, mm.
    pub facing_mm: f64,
    /// Depth of a cut, mm of radius and of Z.
    pub depth_mm: f64,
    /// Feed, mm per revolution.
    pub feed_mm_per_rev: f64,
    /// The nose and both cutting edges about the gauge point, (X, Z): what of the tool cuts.
    pub edges: &'a [DVec2],
}

/// A cut along Z on one radius.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Level {
    /// Way into it, from above; of a level that begins before the end face none.
    pub entry: Vec<DVec2>,
    /// Radius of the gauge point, mm.
    pub x_mm: f64,
    /// Z at which it begins and ends, mm.
    pub z_mm: (f64, f64),
}

/// Comment in front of the cut along the contour.
pub(super) const ALONG: &str = "along the contour, the allowance is left";

/// Largest sagitta of the chords of the boundary's arcs, mm: far below an allowance.
const SAGITTA_MM: f64 = 0.002;
/// Length below which a cut is none, mm.
const SHORT_MM: f64 = 0.05;
/// Way back from a wall along X and Z, mm, where there is room.
const BACK_MM: f64 = 0.5;
/// Feed out of the bar once the tool is off the wall, mm per revolution: in air, and quick enough
/// that a rapid would save little.
const OUT_MM_PER_REV: f64 = 1.0;

impl Roughing<'_> {
    /// What it does, for a program's head.
    pub(super) fn about(&self, piece: &Workpiece) -> String {
        format!(
            "faced and roughed from a bar of {} mm, its end at Z {}, {} mm deep a cut",
            number(piece.before_mm, 3),
            number(piece.length_mm, 3),
            number(self.depth_mm, 3)
        )
    }

    /// Corners of the boundary from the end face to the chuck, and up beyond the bar there.
    fn corners(&self) -> Vec<DVec2> {
        let mut corners: Vec<DVec2> =
            self.boundary.iter().rev().flat_map(|p| p.points(SAGITTA_MM).into_iter().rev()).collect();
        if let Some(last) = corners.last().copied() {
            corners.push(DVec2::new(2.0 * self.bar_mm.max(last.x), last.y));
        }
        corners
    }

    /// Z of the face that leaves the allowance, mm.
    fn face_mm(&self) -> f64 {
        self.boundary.last().map_or(0.0, |piece| piece.to.y)
    }

    /// Z of the facing cuts, the last on the face that leaves the allowance, mm.
    pub(crate) fn faces_mm(&self) -> Vec<f64> {
        let count = (self.facing_mm / self.depth_mm - 1e-9).ceil().max(0.0) as usize;
        let step = self.facing_mm / count.max(1) as f64;
        (1..=count).map(|k| self.face_mm() + self.facing_mm - step * k as f64).collect()
    }

    /// The cuts along Z, from the bar inwards.
    pub(crate) fn levels(&self) -> Vec<Level> {
        let corners = self.corners();
        // below the innermost place of what is not the end face there is nothing to cut along Z
        let face = self.face_mm() - SHORT_MM;
        let least = corners.iter().filter(|c| c.y < face).map(|c| c.x).fold(self.bar_mm, f64::min).max(0.0);
        let count = ((self.bar_mm - least) / self.depth_mm - 1e-9).ceil().max(0.0) as usize;
        let step = (self.bar_mm - least) / count.max(1) as f64;
        let at = |k: usize| self.bar_mm - step * k as f64;
        (1..=count).flat_map(|k| self.on_radius(&corners, at(k), at(k - 1))).collect()
    }

    /// The cuts on the radius `x_mm`; the bar is cut to `above_mm` before.
    fn on_radius(&self, corners: &[DVec2], x_mm: f64, above_mm: f64) -> Vec<Level> {
        let mut levels = Vec::new();
        let mut open = corners
            .first()
            .is_some_and(|c| c.x <= x_mm)
            .then(|| (Vec::new(), self.face_mm() + self.facing_mm));
        for (i, pair) in corners.windows(2).enumerate() {
            let (a, b) = (pair[0], pair[1]);
            if (a.x <= x_mm) == (b.x <= x_mm) {
                continue;
            }
            let z = a.y + (b.y - a.y) * (x_mm - a.x) / (b.x - a.x);
            match open.take() {
                Some((entry, from)) if from - z > SHORT_MM => {
                    levels.push(Level { entry, x_mm, z_mm: (from, z) });
                }
                Some(_) => {}
                None => open = Some((down(corners, i, DVec2::new(x_mm, z), above_mm), z)),
            }
        }
        levels
    }

    /// The blocks, from the clear diameter beyond the end face and back to it; `clear_mm` is that
    /// diameter, `first_mm` the Z there.
    pub(super) fn blocks(&self, d: Dialect, clear_mm: f64, first_mm: f64) -> Vec<String> {
        let mut lines = vec![d.comment("facing and roughing, explicit blocks")];
        let (feed, out) = (number(self.feed_mm_per_rev, 4), number(OUT_MM_PER_REV, 4));
        let x = |radius: f64| d.axis('X', &number(2.0 * radius, 3));
        let z = |at: f64| d.axis('Z', &number(at, 3));
        let centre = self.boundary.last().map_or(0.0, |piece| piece.to.x);
        let clear = 0.5 * clear_mm;
        for face in self.faces_mm() {
            lines.push(format!("G00 {}", z(face)));
            lines.push(format!("G01 {} F{feed}", x(centre)));
            lines.push(format!("{} F{out}", z(first_mm)));
            lines.push(format!("G00 {}", x(clear)));
        }
        for level in self.levels() {
            let (from, to) = level.z_mm;
            match level.entry.first() {
                None => {
                    lines.push(format!("G00 {}", z(first_mm)));
                    lines.push(x(level.x_mm));
                }
                Some(start) => lines.push(format!("G00 {}", z(start.y))),
            }
            let begin = lines.len();
            lines.extend(level.entry.iter().map(|at| format!("{} {}", x(at.x), z(at.y))));
            lines.push(z(to));
            lines[begin] = format!("G01 {} F{feed}", lines[begin]);
            let back = BACK_MM.min((from - to) / 3.0);
            lines.push(format!("{} {}", x(level.x_mm + back), z(to + back)));
            lines.push(format!("{} F{out}", x(clear)));
        }
        lines.extend(self.along_the_boundary(d, (clear, first_mm), &feed));
        lines
    }

    /// The cut that leaves the allowance everywhere.
    fn along_the_boundary(&self, d: Dialect, (clear, first_mm): (f64, f64), feed: &str) -> Vec<String> {
        let corners = self.corners();
        let word =
            |at: DVec2| format!("{} {}", d.axis('X', &number(2.0 * at.x, 3)), d.axis('Z', &number(at.y, 3)));
        let Some(first) = corners.first() else { return Vec::new() };
        let mut lines = vec![d.comment(ALONG)];
        lines.push(format!("G00 {}", d.axis('Z', &number(first_mm, 3))));
        lines.push(format!("G01 {} F{feed}", d.axis('X', &number(2.0 * first.x, 3))));
        let mut stands = String::new();
        // the last corner is the way out beyond the bar
        for at in &corners[..corners.len() - 1] {
            let to = word(*at);
            if to != stands {
                lines.push(to.clone());
            }
            stands = to;
        }
        lines.push(d.axis('X', &number(2.0 * clear, 3)));
        lines
    }
}

/// The way down to `at` on the line `i` of the boundary: along the boundary from where it falls
/// below what is cut already, or from its peak.
fn down(corners: &[DVec2], i: usize, at: DVec2, above_mm: f64) -> Vec<DVec2> {
    let mut way = vec![at];
    for (k, corner) in corners[..=i].iter().enumerate().rev() {
        let below = way[way.len() - 1];
        if corner.x < below.x {
            break;
        }
        if corner.x > above_mm {
            let next = if k == i { at } else { corners[k + 1] };
            let share = (above_mm - next.x) / (corner.x - next.x);
            way.push(next.lerp(*corner, share.clamp(0.0, 1.0)));
            break;
        }
        way.push(*corner);
    }
    way.dedup_by(|a, b| a.distance(*b) < 1e-9);
    way.reverse();
    way
}
