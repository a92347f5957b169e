//! A line or an arc by its ends and the angles of its normal there.

use std::f64::consts::TAU;

use glam::DVec2;

/// Centre and signed radius of an arc: its points are centre + radius·n(a), so that the radius is
/// negative where the outline is concave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Arc {
    /// Centre (X, Z), mm.
    pub centre: DVec2,
    /// Radius, mm; below 0 for a concave arc.
    pub radius_mm: f64,
}

/// A line, or an arc of at most half a turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Piece {
    /// First point (X, Z), mm.
    pub from: DVec2,
    /// Last point (X, Z), mm.
    pub to: DVec2,
    /// Angle a of the normal at the first point, rad.
    pub from_rad: f64,
    /// Angle of the normal at the last point, rad.
    pub to_rad: f64,
    /// The arc; none for a line.
    pub arc: Option<Arc>,
}

/// The unit normal n(a).
pub(crate) fn normal(a: f64) -> DVec2 {
    DVec2::from_angle(a)
}

/// `angle` moved by whole turns to within half a turn of `near`, rad.
pub(crate) fn unwrapped(angle: f64, near: f64) -> f64 {
    angle - TAU * ((angle - near) / TAU).round()
}

impl Piece {
    /// A line with the normal at the angle `a`, rad.
    pub(crate) fn line(from: DVec2, to: DVec2, a: f64) -> Self {
        Self { from, to, from_rad: a, to_rad: a, arc: None }
    }

    /// An arc between the angles of its normal, rad.
    pub(crate) fn arc(arc: Arc, from_rad: f64, to_rad: f64) -> Self {
        let at = |a| arc.centre + arc.radius_mm * normal(a);
        Self { from: at(from_rad), to: at(to_rad), from_rad, to_rad, arc: Some(arc) }
    }

    /// Length, mm.
    pub(crate) fn length_mm(&self) -> f64 {
        match self.arc {
            None => self.from.distance(self.to),
            Some(arc) => (arc.radius_mm * (self.to_rad - self.from_rad)).abs(),
        }
    }

    /// Angle of the normal at a share of its length, rad.
    pub(crate) fn angle_at(&self, share: f64) -> f64 {
        self.from_rad + share * (self.to_rad - self.from_rad)
    }

    /// The point at a share of its length.
    pub(crate) fn at(&self, share: f64) -> DVec2 {
        match self.arc {
            None => self.from.lerp(self.to, share),
            Some(arc) => arc.centre + arc.radius_mm * normal(self.angle_at(share)),
        }
    }

    /// Share of the length at which it passes a point that lies on it.
    pub(crate) fn share_of(&self, point: DVec2) -> f64 {
        match self.arc {
            None => {
                let along = self.to - self.from;
                (point - self.from).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)
            }
            Some(arc) => {
                let turn = self.to_rad - self.from_rad;
                let out = (point - arc.centre) * arc.radius_mm.signum();
                let middle = self.angle_at(0.5);
                (unwrapped(out.to_angle(), middle) - self.from_rad) / turn
            }
        }
    }

    /// The part of it between two shares of its length.
    pub(crate) fn between(&self, first: f64, last: f64) -> Self {
        Self {
            from: if first == 0.0 { self.from } else { self.at(first) },
            to: if last == 1.0 { self.to } else { self.at(last) },
            from_rad: self.angle_at(first),
            to_rad: self.angle_at(last),
            arc: self.arc,
        }
    }

    /// Moved by a vector.
    pub(crate) fn moved(&self, by: DVec2) -> Self {
        let arc = self.arc.map(|arc| Arc { centre: arc.centre + by, ..arc });
        Self { from: self.from + by, to: self.to + by, arc, ..*self }
    }

    /// Points along it whose chords stay within `sagitta_mm` of it, both ends included.
    pub(crate) fn points(&self, sagitta_mm: f64) -> Vec<DVec2> {
        let Some(arc) = self.arc else { return vec![self.from, self.to] };
        // a chord of the angle δ lies r(1 − cos(δ/2)) ≈ r·δ²/8 inside the arc
        let step = (8.0 * sagitta_mm / arc.radius_mm.abs().max(sagitta_mm)).sqrt();
        let chords = ((self.to_rad - self.from_rad).abs() / step).ceil().max(1.0) as usize;
        let inner = (1..chords).map(|k| self.at(k as f64 / chords as f64));
        std::iter::once(self.from).chain(inner).chain([self.to]).collect()
    }
}
