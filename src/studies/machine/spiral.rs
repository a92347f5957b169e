//! A face on an Archimedean spiral: its points, and which lobes of a face they show as others.
//!
//! A probe that moves along the radius while the spindle turns takes m points a turn: n lobes read
//! as the nearest |n − j·m|, and those beside a multiple of m as a tilt, which every flatness takes
//! out.

use std::f64::consts::TAU;

use glam::DVec3;
use serde::Serialize;

use crate::gauge::form::{FormError, minimum_zone_plane};

/// Height of the lobes at the rim, mm.
const LOBES_MM: f64 = 50e-6;
/// Most lobes of the report.
const MOST_LOBES: usize = 40;
/// Points of a turn that show all lobes of the report: seven a wave.
const DENSE: usize = 289;

/// An Archimedean spiral from half a pitch to the rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spiral {
    /// Radius of the rim, mm.
    pub radius_mm: f64,
    /// Position of Z at which the face is turned, mm.
    pub z_mm: f64,
    /// Growth of the radius a turn, mm.
    pub pitch_mm: f64,
    /// Points a turn.
    pub points_per_turn: usize,
}

/// A point of a spiral.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpiralPoint {
    /// Radius, mm.
    pub radius_mm: f64,
    /// Angle on the part, rad.
    pub angle_rad: f64,
}

/// What becomes of lobes that grow with the radius to ±0.05 µm at the rim.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Alias {
    /// Lobes a turn.
    pub order: usize,
    /// What they read as.
    pub reads_as: usize,
    /// Flatness (minimum zone) of the face, µm.
    pub true_um: f64,
    /// Flatness that the spiral's points show, µm; the least over two phases a quarter of a wave
    /// apart.
    pub shown_um: f64,
}

impl Alias {
    /// Whether the spiral shows less than half of what there is (a first order is a tilt, and none
    /// of the form).
    pub(crate) fn is_hidden(&self) -> bool {
        self.true_um > 1e-6 && self.shown_um < 0.5 * self.true_um
    }
}

impl SpiralPoint {
    /// The point with a height.
    pub(crate) fn place(&self, height_mm: f64) -> DVec3 {
        DVec3::new(self.radius_mm * self.angle_rad.cos(), self.radius_mm * self.angle_rad.sin(), height_mm)
    }
}

impl Spiral {
    /// The points, from the middle to the rim.
    pub(crate) fn points(&self) -> Vec<SpiralPoint> {
        let start = 0.5 * self.pitch_mm;
        let per_turn = self.points_per_turn as f64;
        let count = ((self.radius_mm - start) / self.pitch_mm * per_turn + 1e-9).floor() as usize + 1;
        let point = |k: usize| {
            let turns = k as f64 / per_turn;
            SpiralPoint { radius_mm: start + self.pitch_mm * turns, angle_rad: TAU * turns.fract() }
        };
        (0..count).map(point).collect()
    }

    /// The report: orders up to twice the points a turn, at most 40.
    ///
    /// # Errors
    /// A spiral too short for a plane.
    pub(crate) fn aliases(&self) -> Result<Vec<Alias>, FormError> {
        let (own, dense) = (self.points(), self.rings());
        (1..=(2 * self.points_per_turn).min(MOST_LOBES))
            .map(|order| {
                let per_turn = self.points_per_turn;
                let beyond = order % per_turn;
                let reads_as = beyond.min(per_turn - beyond);
                let quarter = self.flatness_um(&own, order, 0.25 * TAU)?;
                let shown_um = self.flatness_um(&own, order, 0.0)?.min(quarter);
                Ok(Alias { order, reads_as, true_um: self.flatness_um(&dense, order, 0.0)?, shown_um })
            })
            .collect()
    }

    /// Close points on the rim and half way to it, where lobes that grow with the radius show all
    /// of their zone.
    fn rings(&self) -> Vec<SpiralPoint> {
        let ring = |radius_mm: f64| {
            let at = move |k: usize| TAU * k as f64 / DENSE as f64;
            (0..DENSE).map(move |k| SpiralPoint { radius_mm, angle_rad: at(k) })
        };
        ring(self.radius_mm).chain(ring(0.5 * self.radius_mm)).collect()
    }

    /// Minimum zone of a face with lobes of a phase at some points.
    fn flatness_um(&self, at: &[SpiralPoint], order: usize, phase_rad: f64) -> Result<f64, FormError> {
        let lobes = |p: &SpiralPoint| (order as f64 * p.angle_rad + phase_rad).cos();
        let height = |p: &SpiralPoint| LOBES_MM * p.radius_mm / self.radius_mm * lobes(p);
        let points: Vec<DVec3> = at.iter().map(|p| p.place(height(p))).collect();
        Ok(1e3 * minimum_zone_plane(&points)?.peak_to_valley())
    }
}
