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

/// Pieces of contours, found by place.
pub(super) struct Contours {
    cell_px: f64,
    cells: HashMap<(i32, i32), Vec<[DVec2; 2]>>,
}

impl Contours {
    /// Contours as places at most a fifth of the blur apart, the shadow on their left.
    pub(super) fn new(contours: &[Vec<DVec2>], reach_px: f64) -> Self {
        let mut all = Self { cell_px: reach_px + 1.0, cells: HashMap::new() };
        for piece in contours.iter().flat_map(|c| c.windows(2)) {
            let key = all.key(0.5 * (piece[0] + piece[1]));
            all.cells.entry(key).or_default().push([piece[0], piece[1]]);
        }
        all
    }

    fn key(&self, p: DVec2) -> (i32, i32) {
        ((p.x / self.cell_px).floor() as i32, (p.y / self.cell_px).floor() as i32)
    }

    /// The pieces that may lie within the reach of a place.
    pub(super) fn near(&self, p: DVec2) -> impl Iterator<Item = &[DVec2; 2]> {
        let (i, j) = self.key(p);
        let cells = (-1..=1).flat_map(move |di| (-1..=1).map(move |dj| (i + di, j + dj)));
        cells.filter_map(|key| self.cells.get(&key)).flatten()
    }

    /// Light at a place, 0 to 1 (and beyond by diffraction); `inside` whether it lies in a shadow.
    pub(super) fn light(&self, blur: &AreaBlur, p: DVec2, inside: bool) -> f64 {
        let (mut turn, mut nearest) = (0.0, f64::INFINITY);
        for [from, to] in self.near(p) {
            let (a, b) = (*from - p, *to - p);
            let along = b - a;
            let t = (-a.dot(along) / along.length_squared()).clamp(0.0, 1.0);
            let distance = (a + along * t).length();
            nearest = nearest.min(distance);
            if distance > blur.reach_px {
                continue;
            }
            let cross = a.perp_dot(b);
            let whole = cross.atan2(a.dot(b));
            let part: f64 = [0.5 - NODE, 0.5 + NODE]
                .into_iter()
                .map(|t| {
                    let q = a + along * t;
                    let square = q.length_squared().max(1e-18);
                    0.5 * blur.energy(square.sqrt()) * cross / square
                })
                .sum();
            turn += part - whole;
        }
        let shadow = f64::from(u8::from(inside)) + turn / TAU;
        1.0 - shadow + if nearest < blur.reach_px { blur.uneven(nearest) } else { 0.0 }
    }
}
