//! The silhouette of an insert: two edges and a nose by its radius in every direction. Places are
//! (column, −row), px.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec2;
use serde::Serialize;

use super::settings::{InsertSettings, Wear};

/// Directions in which the truth's support is taken as the farthest of the nose's places, a degree.
const PER_DEGREE: f64 = 50.0;

/// The silhouette.
#[derive(Clone, Debug)]
pub(super) struct Shape {
    /// Centre of the nose.
    pub(super) centre: DVec2,
    /// Outward normals of both edges, counter-clockwise over the nose, rad.
    pub(super) from_rad: f64,
    /// Angle between them, rad.
    pub(super) sweep_rad: f64,
    /// Radius as ground, px.
    pub(super) radius_px: f64,
    wear: Vec<Wear>,
    um_per_px: f64,
}

/// What is true of a rendered insert.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Truth {
    /// Included angle, degrees.
    pub angle_deg: f64,
    /// Centre: column and row.
    pub centre_px: [f64; 2],
    /// Radius as ground, px.
    pub nominal_radius_px: f64,
    /// Directions of the outward normals of both edges, degrees.
    pub edge_normals_deg: [f64; 2],
    /// Mean radius of the nose over its directions, px.
    pub mean_radius_px: f64,
    /// Radius in directions half a degree apart, from edge to edge: degrees and px.
    pub radii: Vec<[f64; 2]>,
    /// Support of the hull about the centre in directions half a degree apart: degrees and px.
    pub support: Vec<[f64; 2]>,
}

impl Shape {
    pub(super) fn new(s: &InsertSettings) -> Self {
        let sweep_rad = PI - s.nose.epsilon_deg.to_radians();
        Self {
            centre: DVec2::new(s.nose.centre_px[0], -s.nose.centre_px[1]),
            from_rad: s.nose.direction_deg.to_radians() - 0.5 * sweep_rad,
            sweep_rad,
            radius_px: 1e3 * s.nose.radius_mm / s.camera.um_per_px,
            wear: s.wear.clone(),
            um_per_px: s.camera.um_per_px,
        }
    }

    /// Outward normals of both edges.
    pub(super) fn normals(&self) -> [DVec2; 2] {
        [self.from_rad, self.from_rad + self.sweep_rad].map(DVec2::from_angle)
    }

    /// Radius of the nose `turn` rad after the first edge's normal, px.
    pub(super) fn radius(&self, turn: f64) -> f64 {
        let mut r = self.radius_px;
        for wear in &self.wear {
            r = self.worn(r, wear, turn);
        }
        r
    }

    fn worn(&self, r: f64, wear: &Wear, turn: f64) -> f64 {
        let off = |deg: f64| (self.from_rad + turn - deg.to_radians() + PI).rem_euclid(TAU) - PI;
        let share = |deg: f64, width: f64| (off(deg).abs() / (0.5 * width.to_radians())).min(1.0);
        let round = |deg: f64, width: f64| (share(deg, width) * FRAC_PI_2).cos().powi(2);
        match *wear {
            Wear::Round { depth_um } => {
                let share = 2.0 * turn / self.sweep_rad - 1.0;
                r - depth_um / self.um_per_px * (share * FRAC_PI_2).cos().powi(2)
            }
            Wear::Flat { direction_deg, depth_um } => {
                let cos = off(direction_deg).cos();
                let plane = self.radius_px - depth_um / self.um_per_px;
                if cos > 0.1 { r.min(plane / cos) } else { r }
            }
            Wear::Dent { direction_deg, width_deg, depth_um } => {
                r - depth_um / self.um_per_px * round(direction_deg, width_deg)
            }
            Wear::Chip { direction_deg, width_deg, depth_um } => {
                r - depth_um / self.um_per_px * (1.0 - share(direction_deg, width_deg))
            }
            Wear::BuiltUpEdge { direction_deg, width_deg, height_um } => {
                r + height_um / self.um_per_px * round(direction_deg, width_deg)
            }
        }
    }

    /// Whether a place lies in the insert.
    pub(super) fn contains(&self, p: DVec2) -> bool {
        let arm = p - self.centre;
        match self.turn_of(arm) {
            Some(turn) => arm.length() < self.radius(turn),
            None => self.normals().iter().all(|n| n.dot(arm) < self.radius_px),
        }
    }

    /// Angle of an arm after the first edge's normal where it is one of the nose's, rad.
    fn turn_of(&self, arm: DVec2) -> Option<f64> {
        let turn = (arm.to_angle() - self.from_rad).rem_euclid(TAU);
        (turn <= self.sweep_rad).then_some(turn)
    }

    /// Places of the nose's contour at most `step` px apart, counter-clockwise, with `beyond` px of
    /// both edges.
    pub(super) fn contour(&self, step: f64, beyond: f64) -> Vec<DVec2> {
        let [a, b] = self.normals();
        let count = (1.5 * self.radius_px * self.sweep_rad / step).ceil().max(64.0) as usize;
        let edge = (beyond / step).ceil() as usize;
        let along = |k: usize| beyond * k as f64 / edge as f64;
        let before = (0..edge).map(|k| self.centre + a * self.radius_px - a.perp() * along(edge - k));
        let nose = (0..=count).map(|k| {
            let turn = self.sweep_rad * k as f64 / count as f64;
            self.centre + DVec2::from_angle(self.from_rad + turn) * self.radius(turn)
        });
        let after = (1..=edge).map(|k| self.centre + b * self.radius_px + b.perp() * along(k));
        before.chain(nose).chain(after).collect()
    }

    /// What is true of it.
    pub(super) fn truth(&self) -> Truth {
        let count = (self.sweep_rad.to_degrees() * PER_DEGREE).round() as usize;
        let turn = |k: usize| self.sweep_rad * k as f64 / count as f64;
        let radii: Vec<f64> = (0..=count).map(|k| self.radius(turn(k))).collect();
        let places: Vec<DVec2> = (0..=count).map(|k| DVec2::from_angle(turn(k)) * radii[k]).collect();
        let half = (2.0 * self.sweep_rad.to_degrees()).round() as usize;
        let at = |i: usize| self.sweep_rad * i as f64 / half as f64;
        let deg = |i: usize| (self.from_rad + at(i)).to_degrees();
        let support = |i: usize| {
            let n = DVec2::from_angle(at(i));
            // the edges begin where the nose ends, at its radius when new
            let edges = [0.0, self.sweep_rad].map(|turn| self.radius_px * DVec2::from_angle(turn));
            places.iter().chain(&edges).map(|p| p.dot(n)).fold(f64::NEG_INFINITY, f64::max)
        };
        let middles = (0..count).map(|k| self.radius(turn(k) + 0.5 * self.sweep_rad / count as f64));
        Truth {
            angle_deg: 180.0 - self.sweep_rad.to_degrees(),
            centre_px: [self.centre.x, -self.centre.y],
            nominal_radius_px: self.radius_px,
            edge_normals_deg: [0, half].map(|i| deg(i).rem_euclid(360.0)),
            mean_radius_px: middles.sum::<f64>() / count as f64,
            radii: (0..=half).map(|i| [deg(i), self.radius(at(i))]).collect(),
            support: (0..=half).map(|i| [deg(i), support(i)]).collect(),
        }
    }
}
