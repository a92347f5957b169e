//! Light down the columns whose edges are not straight within the blur: corners, threads, and edges
//! in motion.
//!
//! Gaussian blur separates, so for light above an edge e(x) of any shape the light on pixel (x, y)
//! is exactly
//!
//! ```text
//! I(x, y) = ∫ K(x - x') B(e(x') - y) dx'
//! K = box ∗ g_σ along the row,   B = box ∗ Φ down the column
//! ```
//!
//! integrated between the outline's corners with four Gauss nodes per panel of half a σ, on steep
//! faces per rise of the edge by σ. Beneath a leaning shoulder's overhang there is light again.
//! Threads, whose corners are not known in advance, have panels of an eighth of a pixel, with an
//! error of 1e-4 px at flanks of tan 60°. Other families have no such form: their light at a point
//! is F(σΦ⁻¹(I)), with I that of a Gaussian of the family's width; where limbs are thick, F turns
//! from that of the limb to that of a face with the direction of I's gradient. That is exact along
//! every straight edge; at a corner of 90° it would err by up to 0.27 of full intensity in
//! monochromatic light from a point source, where the rings of both edges cross. There the
//! shoulders of cylinders are computed from the amplitudes (`optics::laser_shoulder`;
//! `tests/inside/render_shaft/corners.rs` compares them with the opaque quadrant). An edge in
//! motion is the mean of its images. Through a lens with aberrations every edge has a profile, a
//! blend of the tables about its place in the field; at a corner the nearest table serves.

use std::sync::LazyLock;

use rayon::prelude::*;

use super::exposure::Instant;
use super::scene::Scene;
use crate::render::kernel::column_edges::{Column, Depth, Edge, PROFILE, Straight};
use crate::render::kernel::params::Window;
use crate::render::optics::edge_spread::LaserShadow;
use crate::render::optics::edge_spread::gaussian::gaussian;
use crate::render::optics::edge_spread::quadrature::{gauss_legendre, panels};
use crate::render::optics::esf_table::{EsfTable, Node, TablePlace};
use crate::render::optics::laser_shoulder::{LaserShoulder, Pieces, Rows, SEEN_UNITS};
use crate::render::silhouette::Turned;

/// Reach of the Gaussian in σ: 1 - Φ(5.25) = 8e-8.
const REACH: f64 = 5.25;

/// Motion of an edge below which only its mean position is used, px: it widens σ = 0.5 px by 3e-7.
const STILL_PX: f64 = 1e-3;

/// Length of panels between known corners, σ; and where corners are not known, px.
const PANEL_SIGMA: f64 = 0.5;
const PANEL_FINE_PX: f64 = 0.125;

/// Nodes per panel.
const NODES: usize = 4;

/// Share of the light below which other families use the distance to the outline itself: 4.75 σ.
const LEAST_SHARE: f64 = 1e-6;

/// One point of the outline with its weight along the row.
#[derive(Clone, Copy, Debug)]
struct Point {
    column: f64,
    weight: f64,
    rows: [f64; 2],
    /// Upper and lower row of the light beneath an overhang.
    gaps: [Option<[f64; 2]>; 2],
}

impl Point {
    /// Rows of one side at which light begins, with weight +1, or ends again, with weight −1.
    fn borders(&self, side: usize) -> impl Iterator<Item = (f64, f64)> {
        let [upper, lower] = self.gaps[side].unwrap_or_default();
        let (begins, ends) = if side == 0 { (lower, upper) } else { (upper, lower) };
        let gap = self.gaps[side].map(|_| [(begins, 1.0), (ends, -1.0)]);
        std::iter::once((self.rows[side], 1.0)).chain(gap.into_iter().flatten())
    }
}

/// Light of the rows of one column past one edge.
struct Line {
    first: i32,
    light: Vec<f32>,
}

/// Inputs of the profiles of a frame.
pub(crate) struct Profiles<'a> {
    pub scene: &'a Scene,
    pub esf: &'a EsfTable,
    pub window: Window,
    pub halo: usize,
    pub instants: &'a [Instant<'a>],
    pub depth: &'a [Depth],
    pub quadrature: &'a [Node],
    /// Segments of the kernel's tables, after which the profiles are stored.
    pub kernel_segments: usize,
}

impl Profiles<'_> {
    /// Upper and lower row of the light beneath an overhang of either edge at a fractional column,
    /// in rows of the full sensor.
    fn gaps_at(&self, turned: &Turned<'_>, field_z_mm: f64, sensor_column: f64) -> [Option<[f64; 2]>; 2] {
        if !(self.scene.is_straight() && self.scene.setup.nominal.optics.distortion.is_none()) {
            return [None; 2];
        }
        let z = self.scene.setup.column_z_mm(field_z_mm, sensor_column);
        let rows = |ends: [f64; 2]| {
            let [a, b] = ends.map(|x| self.scene.setup.row_of_x(x));
            [a.min(b), a.max(b)]
        };
        [true, false].map(|top| turned.gap(z, top).map(rows))
    }

    /// Straight-edge equivalent of an edge (0 upper, 1 lower) of a column at an instant.
    fn straight(&self, instant: &Instant<'_>, column: usize, side: usize) -> Straight {
        let window = instant.edges[column..column + 2 * self.scene.blur.reach() + 1].iter();
        self.scene.blur.straight(window.map(|e| if side == 0 { e.top_px } else { e.bottom_px }))
    }

    /// Whether a corner of the outline lies within the blur about a column of a frame.
    fn is_broken(&self, column: usize) -> bool {
        if !self.scene.outline.has_breaks() {
            return false;
        }
        let mut reach_px = 5.25 * self.scene.largest_sigma_px + 1.0;
        if let Some(laser) = self.scene.laser_shoulders() {
            reach_px = reach_px.max(SEEN_UNITS * laser.unit_um() * 1e-3 / self.scene.setup.pixel_mm);
        }
        let reach_mm = reach_px * self.scene.setup.pixel_mm + self.scene.margin_mm;
        let column = f64::from(self.window.column) + column as f64;
        self.instants.iter().any(|i| {
            let z = self.scene.setup.column_z_mm(i.field_z_mm, column);
            self.scene.outline.is_broken(z - reach_mm, z + reach_mm)
        })
    }

    /// Columns of the full sensor at which the visible outline has corners at an instant, and
    /// whether the list is complete.
    fn corners(&self, instant: &Instant<'_>, low: f64, high: f64) -> (Vec<f64>, bool) {
        let setup = &self.scene.setup;
        let (rows, columns) = (setup.rows(), setup.columns());
        let distortion = &setup.nominal.optics.distortion;
        let z = |column: f64| setup.column_z_mm(instant.field_z_mm, column);
        let (from, to) = (z(low) - self.scene.margin_mm, z(high) + self.scene.margin_mm);
        let mut corners = Vec::new();
        for s in self.scene.outline.breaks_mm(from, to) {
            for (z_mm, x_mm) in instant.turned.corner_seen(s) {
                let column = setup.centre_column() + (z_mm - instant.field_z_mm) / setup.pixel_mm;
                let row = setup.row_of_x(x_mm);
                corners.push(if distortion.is_none() {
                    column
                } else {
                    distortion.distort_px(row, column, rows, columns).1
                });
            }
        }
        corners.sort_by(f64::total_cmp);
        corners.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        let helices = &self.scene.outline.shaft().features.helices;
        let known = self.scene.is_straight() && !helices.iter().any(|h| h.from_mm <= to && h.to_mm >= from);
        (corners, known)
    }

    /// Computes profiles for the columns that need them and returns these, four rows per element.
    pub(crate) fn add(&self, columns: &mut [Column]) -> Vec<[f32; 4]> {
        let broken: Vec<bool> = (0..columns.len()).map(|c| self.is_broken(c)).collect();
        let moved = |c: usize| {
            let at = |i: &Instant<'_>| i.edges[c + self.halo];
            let first = at(&self.instants[0]);
            self.instants.iter().any(|i| {
                let e = at(i);
                (e.top_px - first.top_px).abs().max((e.bottom_px - first.bottom_px).abs()) > STILL_PX
            })
        };
        let by_field = self.esf.is_by_field();
        let wanted: Vec<usize> = (0..columns.len()).filter(|&c| broken[c] || by_field || moved(c)).collect();
        if wanted.is_empty() {
            return Vec::new();
        }
        let outlines: Vec<Vec<Point>> = self.instants.par_iter().map(|i| self.outline(i, &broken)).collect();
        let lines: Vec<[Option<Line>; 2]> = wanted
            .par_iter()
            .map(|&c| [0, 1].map(|side| self.line(c, side, broken[c].then_some(&outlines))))
            .collect();
        self.place(columns, &wanted, lines)
    }

    /// Stores the lines after the tables, and their indices in the columns.
    fn place(
        &self,
        columns: &mut [Column],
        wanted: &[usize],
        lines: Vec<[Option<Line>; 2]>,
    ) -> Vec<[f32; 4]> {
        let start = 4 * self.kernel_segments;
        let mut light: Vec<f32> = Vec::new();
        for (&c, pair) in wanted.iter().zip(lines) {
            for (side, line) in pair.into_iter().enumerate() {
                let Some(line) = line else { continue };
                let edge = Edge {
                    whole: line.first,
                    part: 0.0,
                    across: if side == 0 { -1.0 } else { 1.0 },
                    along: 0.0,
                    table: PROFILE | (start + light.len()) as u32,
                    blend: line.light.len() as f32,
                };
                if side == 0 {
                    columns[c].top = edge;
                } else {
                    columns[c].bottom = edge;
                }
                light.extend(line.light);
            }
        }
        // Rounded up, so that a device's buffers also fit the next frame.
        light.resize(light.len().next_power_of_two().max(4), 0.0);
        light.chunks_exact(4).map(|c| [c[0], c[1], c[2], c[3]]).collect()
    }

    fn table(&self, column: usize, side: usize, extra_px2: f64) -> TablePlace {
        let depth = self.depth.get(column).copied().unwrap_or_default();
        let y_mm = depth.y_mm[side];
        self.esf
            .nearest_in_field(self.in_field(column, side), y_mm)
            .unwrap_or_else(|| self.esf.place(y_mm, depth.radius_mm, extra_px2))
    }

    /// Tables and shares of a straight edge: several where its place in the field has an effect.
    fn tables(&self, column: usize, side: usize, extra_px2: f64) -> Vec<(TablePlace, f64)> {
        let y_mm = self.depth.get(column).copied().unwrap_or_default().y_mm[side];
        self.esf
            .in_field(self.in_field(column, side), y_mm)
            .unwrap_or_else(|| vec![(self.table(column, side, extra_px2), 1.0)])
    }

    /// Place of an edge in the field: out into its light and along it, half diagonals.
    fn in_field(&self, column: usize, side: usize) -> [f64; 2] {
        let setup = &self.scene.setup;
        let edges = &self.instants[0].edges[column + self.halo];
        let row = f64::from(self.window.row) + if side == 0 { edges.top_px } else { edges.bottom_px };
        let half = 0.5 * (setup.rows() as f64).hypot(setup.columns() as f64);
        let down = (row - setup.centre_row()) / half;
        let along = (f64::from(self.window.column) + column as f64 - setup.centre_column()) / half;
        [if side == 0 { -down } else { down }, along]
    }

    /// Standard deviation of the Gaussian equivalent to the edge spread of a column, px.
    fn sigma(&self, column: usize, side: usize) -> f64 {
        if self.esf.widens { self.table(column, side, 0.0).scale_px } else { self.esf.blur_px }
    }

    /// The wider one of a column's edges.
    fn widest(&self, column: usize) -> f64 {
        self.sigma(column, 0).max(self.sigma(column, 1))
    }

    /// The outline at an instant about all broken columns, between its corners.
    fn outline(&self, instant: &Instant<'_>, broken: &[bool]) -> Vec<Point> {
        let rule = gauss_legendre(NODES);
        let mut nodes = Vec::new();
        let mut covered = f64::NEG_INFINITY;
        let mut c = 0;
        while c < broken.len() {
            if !broken[c] {
                c += 1;
                continue;
            }
            let end = broken[c..].iter().position(|b| !b).map_or(broken.len(), |n| c + n);
            let sigma = self.widest(c).max(self.widest(end - 1));
            let reach = REACH * sigma + 0.5;
            let low = f64::from(self.window.column) + c as f64 - reach;
            let low = low.max(covered);
            let high = f64::from(self.window.column) + (end - 1) as f64 + reach;
            let (corners, known) = self.corners(instant, low, high);
            if known {
                let inner = corners.into_iter().filter(|c| *c > low && *c < high);
                let ends: Vec<f64> = std::iter::once(low).chain(inner).chain([high]).collect();
                for piece in ends.windows(2) {
                    let panel = sigma * PANEL_SIGMA.min(1.0 / self.steepness(instant, piece[0], piece[1]));
                    nodes.extend(panels(piece[0], piece[1], &[], panel, &rule));
                }
            } else {
                nodes.extend(panels(low, high, &corners, PANEL_FINE_PX.min(PANEL_SIGMA * sigma), &rule));
            }
            covered = high;
            c = end;
        }
        nodes.par_iter().map(|&(column, weight)| self.point(instant, column, weight)).collect()
    }

    fn point(&self, instant: &Instant<'_>, column: f64, weight: f64) -> Point {
        let row0 = f64::from(self.window.row);
        let e = self.scene.edges_at(&instant.turned, instant.field_z_mm, column);
        let gaps = self.gaps_at(&instant.turned, instant.field_z_mm, column);
        let gaps = gaps.map(|gap| gap.map(|rows| rows.map(|r| r - row0)));
        let rise = instant.rise_at(column - f64::from(self.window.column) + self.halo as f64);
        let rows = [e.top_px - rise.top_px - row0, e.bottom_px + rise.bottom_px - row0];
        Point { column, weight, rows, gaps }
    }

    /// Slope of the outline between two corners, rows per column: large on the face of a leaning
    /// shoulder.
    fn steepness(&self, instant: &Instant<'_>, low: f64, high: f64) -> f64 {
        let within = 1e-6 * (high - low);
        let [a, b] = [low + within, high - within].map(|column| self.point(instant, column, 0.0));
        let rise = |side: usize| {
            let pairs = a.borders(side).zip(b.borders(side));
            pairs.map(|((from, _), (to, _))| (to - from).abs()).fold(0.0, f64::max)
        };
        rise(0).max(rise(1)) / (high - low).max(f64::MIN_POSITIVE)
    }

    fn line(&self, column: usize, side: usize, outlines: Option<&Vec<Vec<Point>>>) -> Option<Line> {
        match (outlines, self.scene.laser_shoulders()) {
            (Some(_), Some(laser)) => self.laser_line(column, side, laser),
            (Some(outlines), None) => self.broken_line(column, side, outlines),
            (None, _) => self.straight_line(column, side),
        }
    }

    /// Rows within the window that an edge between two rows affects.
    fn rows(&self, (low, high): (f64, f64), reach: f64) -> Option<(i32, usize)> {
        let first = ((low - reach).floor() as i32).max(0);
        let last = ((high + reach).ceil() as i32).min(self.window.rows as i32 - 1);
        (last >= first).then(|| (first, (last - first + 1) as usize))
    }

    /// Mean over the instants of a straight edge's images.
    fn straight_line(&self, column: usize, side: usize) -> Option<Line> {
        let sign = if side == 0 { -1.0 } else { 1.0 };
        let straights: Vec<Straight> = self.instants.iter().map(|i| self.straight(i, column, side)).collect();
        let range = straights
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), s| (a.min(s.row), b.max(s.row)));
        let slope = straights.iter().map(|s| s.slope.abs()).fold(0.0, f64::max);
        let widest = self.table(column, side, 0.0).scale_px * 1.1;
        let reach = f64::from(self.esf.reach) * widest * slope.hypot(1.0) + 0.5 * (1.0 + slope);
        let (first, count) = self.rows(range, reach)?;
        let mut light = vec![0.0; count];
        for (instant, s) in self.instants.iter().zip(&straights) {
            let cos = 1.0 / s.slope.hypot(1.0);
            let places = self.tables(column, side, s.excess_variance * cos * cos);
            for (r, light) in light.iter_mut().enumerate() {
                let above = (f64::from(first) + r as f64 - s.row) * sign;
                let node = |n: &Node| {
                    let d = above + sign * (f64::from(n.down) - s.slope * f64::from(n.along));
                    let lit = |(place, share): &(TablePlace, f64)| share * self.esf.sample(place, d * cos);
                    f64::from(n.weight) * places.iter().map(lit).sum::<f64>()
                };
                *light += instant.weight * self.quadrature.iter().map(node).sum::<f64>();
            }
        }
        Some(Line { first, light: light.into_iter().map(|v| v as f32).collect() })
    }

    /// The outline's level pieces about a column, each at its row nearest to the column.
    fn pieces(&self, instant: &Instant<'_>, laser: &LaserShoulder, at: f64, side: usize) -> Pieces {
        let (low, high) = laser.about(at);
        let (mut corners, _) = self.corners(instant, low, high);
        corners.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
        let ends = [&[f64::NEG_INFINITY][..], &corners, &[f64::INFINITY]].concat();
        let row = |e: &[f64]| {
            self.point(instant, at.clamp(e[0] + 1e-6, (e[1] - 1e-6).max(e[0] + 1e-6)), 0.0).rows[side]
        };
        let rows = ends.windows(2).map(row).collect();
        Pieces { corners, rows, sign: if side == 0 { 1.0 } else { -1.0 } }
    }

    /// Mean over the instants of the images of shoulders in laser light.
    fn laser_line(&self, column: usize, side: usize, laser: &LaserShadow) -> Option<Line> {
        let at = f64::from(self.window.column) + column as f64;
        let place = self.table(column, side, 0.0);
        let laser = LaserShoulder::new(laser, self.scene.setup.pixel_mm * 1e3, place.scale_px);
        let pieces: Vec<Pieces> = self.instants.iter().map(|i| self.pieces(i, &laser, at, side)).collect();
        let seen = pieces.iter().flat_map(|p| laser.rows_seen(p, at));
        let range = seen.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), row| (a.min(row), b.max(row)));
        let esf = self.esf.over_pixel().unwrap_or(self.esf);
        let (first, count) = self.rows(range, f64::from(esf.reach) * place.scale_px + 0.5)?;
        let mut light = vec![0.0; count];
        for (instant, pieces) in self.instants.iter().zip(&pieces) {
            let rows = Rows { at, first: f64::from(first), weight: instant.weight };
            laser.add(pieces, (esf, &place), rows, &mut light);
        }
        Some(Line { first, light: light.into_iter().map(|v| v as f32).collect() })
    }

    /// Mean over the instants of the outline's images.
    fn broken_line(&self, column: usize, side: usize, outlines: &[Vec<Point>]) -> Option<Line> {
        let sigma = self.sigma(column, side);
        let at = f64::from(self.window.column) + column as f64;
        let reach = REACH * sigma + 0.5;
        let windows: Vec<&[Point]> = outlines
            .iter()
            .map(|o| {
                let first = o.partition_point(|p| p.column < at - reach);
                let last = o.partition_point(|p| p.column <= at + reach);
                &o[first..last]
            })
            .collect();
        let range = windows
            .iter()
            .flat_map(|w| w.iter())
            .flat_map(|p| p.borders(side))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (row, _)| (a.min(row), b.max(row)));
        let blurred =
            if self.esf.widens { reach } else { f64::from(self.esf.reach) * self.esf.scale_px + 0.5 };
        let (first, count) = self.rows(range, blurred)?;
        let mut light = vec![0.0; count];
        let place = self.table(column, side, 0.0);
        for (instant, points) in self.instants.iter().zip(windows) {
            let image = Image { points, side, sigma, at, weight: instant.weight };
            if self.esf.widens {
                image.add_gaussian(f64::from(first), &mut light);
            } else {
                image.add_family(self, &place, f64::from(first), &mut light);
            }
        }
        Some(Line { first, light: light.into_iter().map(|v| v as f32).collect() })
    }
}

/// The outline about one column.
struct Image<'a> {
    points: &'a [Point],
    side: usize,
    sigma: f64,
    at: f64,
    /// Share of the exposure.
    weight: f64,
}

impl Image<'_> {
    /// Adds weight·I(x, y) for the rows from `first` on.
    fn add_gaussian(&self, first: f64, light: &mut [f64]) {
        let sign = if self.side == 0 { 1.0 } else { -1.0 };
        let weights: Vec<(f64, f64)> = self
            .points
            .iter()
            .flat_map(|p| {
                let t = self.at - p.column;
                let along = gaussian((t + 0.5) / self.sigma).0 - gaussian((t - 0.5) / self.sigma).0;
                p.borders(self.side).map(move |(row, share)| (row, share * self.weight * p.weight * along))
            })
            .collect();
        for (r, light) in light.iter_mut().enumerate() {
            let row = first + r as f64;
            *light += weights.iter().map(|(e, w)| w * self.down(sign * (e - row))).sum::<f64>();
        }
    }

    /// B: light on a pixel whose centre lies `above` rows within the light of a level edge.
    fn down(&self, above: f64) -> f64 {
        let step = |u: f64| self.sigma * blurred_step(u / self.sigma);
        step(above + 0.5) - step(above - 0.5)
    }

    /// As [`Self::add_gaussian`], for a family with a table only.
    fn add_family(&self, all: &Profiles<'_>, place: &TablePlace, first: f64, light: &mut [f64]) {
        let face = all.esf.face();
        for node in all.quadrature_over_pixel() {
            let x = self.at + node.0;
            let weights: Vec<f64> = self
                .points
                .iter()
                .map(|p| p.weight * gaussian((x - p.column) / self.sigma).1 / self.sigma)
                .collect();
            let total: f64 = weights.iter().sum();
            for (r, light) in light.iter_mut().enumerate() {
                let y = first + r as f64 + node.1;
                let d = self.distance(x, y, &weights, total);
                let mut lit = all.esf.sample(place, d);
                if let Some(face) = &face {
                    lit += self.facing([x, y], &weights) * (all.esf.sample(face, d) - lit);
                }
                *light += self.weight * node.2 * lit;
            }
        }
    }

    /// Share of a face along the light in the edge that casts the shadow at a point: sin² of the
    /// angle between the gradient of the Gaussian light and the column. Limbs and faces have edge
    /// spreads of their own.
    fn facing(&self, [x, y]: [f64; 2], weights: &[f64]) -> f64 {
        let sign = if self.side == 0 { 1.0 } else { -1.0 };
        let (mut sums, mut down) = ([0.0; 4], 0.0);
        for (p, w) in self.points.iter().zip(weights) {
            let (mut lit, mut dense) = (0.0, 0.0);
            for (row, sense) in p.borders(self.side) {
                let (share, density) = gaussian(sign * (row - y) / self.sigma);
                lit += sense * share;
                dense += sense * density;
            }
            let falls = w * (p.column - x) / (self.sigma * self.sigma);
            sums = [sums[0] + w, sums[1] + falls, sums[2] + w * lit, sums[3] + falls * lit];
            down -= w * sign * dense / self.sigma;
        }
        // The slope along the row of the mean Σwl/Σw.
        let along = sums[3] - sums[2] * sums[1] / sums[0];
        let square = along * along + down * down;
        if square > 0.0 { along * along / square } else { 0.0 }
    }

    /// Distance (px) into the light of a straight edge with the same Gaussian light.
    fn distance(&self, x: f64, y: f64, weights: &[f64], total: f64) -> f64 {
        let sign = if self.side == 0 { 1.0 } else { -1.0 };
        let step = |u: f64| gaussian(u / self.sigma).0;
        let (mut lit, mut dark) = (0.0, 0.0);
        for (p, w) in self.points.iter().zip(weights) {
            let u = |row: f64| sign * (row - y);
            let beneath: f64 = p.borders(self.side).skip(1).map(|(row, sense)| sense * step(u(row))).sum();
            let (share, hidden) =
                (step(u(p.rows[self.side])) + beneath, step(-u(p.rows[self.side])) - beneath);
            lit += w * share;
            dark += w * hidden;
        }
        let share = lit.min(dark).max(0.0) / total;
        if share > LEAST_SHARE {
            let u = std::f64::consts::SQRT_2 * statrs::function::erf::erfc_inv(2.0 * share);
            return if lit < dark { -u * self.sigma } else { u * self.sigma };
        }
        let nearest = self.points.windows(2).map(|p| self.gap(p, x, y)).fold(f64::INFINITY, f64::min);
        if lit < dark { -nearest } else { nearest }
    }

    /// Distance of (x, y) from the outline between two neighbouring points.
    fn gap(&self, p: &[Point], x: f64, y: f64) -> f64 {
        let at = |p: &Point| glam::DVec2::new(p.column - x, p.rows[self.side] - y);
        let (a, b) = (at(&p[0]), at(&p[1]));
        let along = b - a;
        let t = (-a.dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (a + t * along).length()
    }
}

impl Profiles<'_> {
    /// Nodes over a pixel in both directions, for steep edges.
    fn quadrature_over_pixel(&self) -> Vec<(f64, f64, f64)> {
        let nodes = crate::render::optics::esf_table::pixel_quadrature(self.esf.sharp_px, 1.0);
        nodes.iter().map(|n| (f64::from(n.along), f64::from(n.down), f64::from(n.weight))).collect()
    }
}

/// Knots per unit of the tabulated vΦ(v) + φ(v): cubic Hermite errs by (1/64)⁴/384·0.4 = 6e-11.
const STEP_KNOTS: f64 = 64.0;
const STEP_REACH: f64 = 7.0;

/// vΦ(v) + φ(v) and Φ(v) at the knots.
static STEP: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| {
    (0..=(2.0 * STEP_REACH * STEP_KNOTS) as usize)
        .map(|i| i as f64 / STEP_KNOTS - STEP_REACH)
        .map(|v| {
            let (cdf, density) = gaussian(v);
            (v * cdf + density, cdf)
        })
        .collect()
});

/// Integral of Φ up to v.
fn blurred_step(v: f64) -> f64 {
    if v >= STEP_REACH {
        return v;
    }
    let place = (v + STEP_REACH) * STEP_KNOTS;
    if place <= 0.0 {
        return 0.0;
    }
    let i = (place as usize).min(STEP.len() - 2);
    let t = place - i as f64;
    let ((a, da), (b, db)) = (STEP[i], STEP[i + 1]);
    let (da, db) = (da / STEP_KNOTS, db / STEP_KNOTS);
    a + t * (da + t * (3.0 * (b - a) - 2.0 * da - db + t * (2.0 * (a - b) + da + db)))
}
