//! A silhouette blurred over its area.
//!
//! The symmetric part of a line-spread function L belongs to one point-spread function that is the
//! same in all directions, whose energy within r is
//!
//! ```text
//! E(r) = 1 − 2∫₀^∞ L(√(r² + t²)) dt
//! ```
//!
//! (Abel's integral). The shadow at a place is then a line integral along the contour, with φ the
//! direction in which the place sees it:
//!
//! ```text
//! S = (1/2π)·∮ E(r) dφ
//! ```
//!
//! which needs the contour within the reach of E only: beyond it E is 1. What the edge-spread
//! function has that is not symmetric (diffraction in light that is not incoherent) has no such
//! function; it is even in the distance from the edge and enters by the distance of the contour.
//! Along a straight edge the sum is the edge-spread function itself.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::DVec2;

use crate::render::optics::edge_spread::EdgeSpread;

/// Knots of E over its reach: linear between them errs by (reach/4096)²/8 of its curvature, 1e-6 of
/// a table of twenty blurs.
const KNOTS: usize = 4096;
/// Steps of Abel's integral.
const STEPS: usize = 3000;
/// Nodes and weights of Gauss-Legendre over ±½, two points.
const NODE: f64 = 0.288_675_134_594_812_9;

/// An edge-spread function as it blurs areas, in px.
pub(super) struct AreaBlur {
    reach_px: f64,
    energy: Vec<f64>,
    spread: EdgeSpread,
    um_per_px: f64,
}

impl AreaBlur {
    pub(super) fn new(spread: EdgeSpread, um_per_px: f64) -> Self {
        let (low, high) = spread.range_um();
        let reach_um = high.max(-low);
        let density = |d: f64| 0.5 * (spread.slope(d) + spread.slope(-d));
        let energy = (0..=KNOTS)
            .map(|k| {
                let r = reach_um * k as f64 / KNOTS as f64;
                let most = (reach_um * reach_um - r * r).max(0.0).sqrt();
                let h = most / STEPS as f64;
                let inner: f64 = (0..STEPS).map(|i| density(r.hypot((i as f64 + 0.5) * h))).sum();
                1.0 - 2.0 * h * inner
            })
            .collect();
        Self { reach_px: reach_um / um_per_px, energy, spread, um_per_px }
    }

    /// Distance beyond which a contour does not affect a place, px.
    pub(super) fn reach_px(&self) -> f64 {
        self.reach_px
    }

    fn energy(&self, r_px: f64) -> f64 {
        let place = r_px / self.reach_px * KNOTS as f64;
        let k = place as usize;
        if k >= KNOTS {
            return 1.0;
        }
        let t = place - k as f64;
        self.energy[k] + t * (self.energy[k + 1] - self.energy[k])
    }

    /// What a piece of the contour from `a` to `b` (from the place) adds to the angle under which
    /// the shadow is seen, beyond that of a sharp image, rad; and its distance, px.
    fn of_piece(&self, a: DVec2, b: DVec2) -> (f64, f64) {
        let along = b - a;
        let t = (-a.dot(along) / along.length_squared()).clamp(0.0, 1.0);
        let distance = (a + along * t).length();
        if distance > self.reach_px {
            return (0.0, distance);
        }
        let cross = a.perp_dot(b);
        let whole = cross.atan2(a.dot(b));
        let part: f64 = [0.5 - NODE, 0.5 + NODE]
            .into_iter()
            .map(|t| {
                let square = (a + along * t).length_squared().max(1e-18);
                0.5 * self.energy(square.sqrt()) * cross / square
            })
            .sum();
        (part - whole, distance)
    }

    /// The part of the edge-spread function that is even in the distance.
    fn uneven(&self, d_px: f64) -> f64 {
        let d = d_px * self.um_per_px;
        0.5 * (self.spread.value(d) + self.spread.value(-d) - 1.0)
    }

    /// Light on a pixel before a straight edge: distance of its centre into the light, px, and the
    /// direction of the edge's normal, rad.
    pub(super) fn straight(&self, d_px: f64, normal_rad: f64) -> f64 {
        self.spread.over_pixel(d_px * self.um_per_px, self.um_per_px, normal_rad)
    }
}

/// Pieces that make one block.
const BLOCK: usize = 4;
/// Distance from which a block's chord stands for its pieces, px: of a contour of 20 px radius the
/// chord of 1 px cuts off 0.004 px², of which a blur lets pass less than 1e-6 so far away, and two
/// nodes a px resolve fringes of 2 px, below which a pixel has averaged them.
const FAR_PX: f64 = 8.0;

/// Contours as blocks of pieces, found by place.
pub(super) struct Contours {
    cell_px: f64,
    places: Vec<DVec2>,
    /// Places of the contour from the first to the last of each block in a cell or beside it.
    cells: HashMap<(i32, i32), Vec<(usize, usize)>>,
}

impl Contours {
    /// Contours as places at most a fifth of the blur apart, the shadow on their left.
    pub(super) fn new(contours: &[Vec<DVec2>], reach_px: f64) -> Self {
        let mut all = Self { cell_px: reach_px + 1.0, places: Vec::new(), cells: HashMap::new() };
        for contour in contours {
            let from = all.places.len();
            all.places.extend(contour);
            let end = all.places.len().saturating_sub(1);
            for first in (from..end).step_by(BLOCK) {
                let last = end.min(first + BLOCK);
                let (i, j) = all.key(0.5 * (all.places[first] + all.places[last]));
                for (di, dj) in (-1..=1).flat_map(|di| (-1..=1).map(move |dj| (di, dj))) {
                    all.cells.entry((i + di, j + dj)).or_default().push((first, last));
                }
            }
        }
        all
    }

    fn key(&self, p: DVec2) -> (i32, i32) {
        ((p.x / self.cell_px).floor() as i32, (p.y / self.cell_px).floor() as i32)
    }

    /// The blocks that may lie within the reach of a place.
    fn near(&self, p: DVec2) -> impl Iterator<Item = (usize, usize)> {
        self.cells.get(&self.key(p)).into_iter().flatten().copied()
    }

    /// Distance from a place to the nearest block within its reach, to a px; `None` without one.
    pub(super) fn distance_px(&self, p: DVec2) -> Option<f64> {
        self.near(p).map(|(first, _)| self.places[first].distance(p)).reduce(f64::min)
    }

    /// Light at a place, 0 to 1 (and beyond by diffraction); `inside` whether it lies in a shadow.
    pub(super) fn light(&self, blur: &AreaBlur, p: DVec2, inside: bool) -> f64 {
        let (mut turn, mut nearest) = (0.0, f64::INFINITY);
        for (first, last) in self.near(p) {
            let step = if self.places[first].distance(p) > FAR_PX { last - first } else { 1 };
            for k in (first..last).step_by(step) {
                let (off, distance) = blur.of_piece(self.places[k] - p, self.places[k + step] - p);
                turn += off;
                nearest = nearest.min(distance);
            }
        }
        let shadow = f64::from(u8::from(inside)) + turn / TAU;
        1.0 - shadow + if nearest < blur.reach_px { blur.uneven(nearest) } else { 0.0 }
    }
}
