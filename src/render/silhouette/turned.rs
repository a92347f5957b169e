//! An outline at one spindle angle: both edges over machine z, with eccentricity, bow, deflection
//! and tilt.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

use super::bent;
use super::outline::{Outline, mean_radius};
use super::segments::{Direction, Rows};
use super::slice::Slice;

/// Most steps that solve s = (z + X(s) sin τ)/cos τ, each of which reduces the error by a factor
/// of |X'| tan τ, and the change (mm) at which they end.
const TILT_STEPS: usize = 40;
const TILT_STILL_MM: f64 = 1e-11;

/// Most steps of [`root`], and the residual (mm) at which it ends.
const ROOT_STEPS: usize = 80;
const ROOT_STILL_MM: f64 = 1e-13;

/// Distance at which the two sides of a shoulder are separated, mm.
pub(super) const BESIDE_MM: f64 = 1e-9;

/// Both edges of the shaft's shadow over a z, in machine coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EdgePair {
    /// Height of the upper edge above the optical axis, mm.
    pub top_mm: f64,
    /// Height of the lower edge above the optical axis, mm.
    pub bottom_mm: f64,
}

/// An outline prepared for a spindle angle: both viewing directions, for all columns.
#[derive(Clone, Debug)]
pub(crate) struct Turned<'a> {
    pub(super) outline: &'a Outline,
    pub(super) cos: f64,
    pub(super) sin: f64,
    pub(super) top: Direction,
    pub(super) bottom: Direction,
    /// Error motion of the spindle.
    pub(super) shift: DVec2,
}

impl Outline {
    /// The outline at spindle angle φ.
    pub(crate) fn turned(&self, angle_deg: f64) -> Turned<'_> {
        let phi = angle_deg.to_radians().rem_euclid(TAU);
        let (sin, cos) = phi.sin_cos();
        let mut shift = DVec2::ZERO;
        for h in &self.shaft.spindle.synchronous {
            let turn = f64::from(h.order) * phi;
            shift.x += 1e-3 * h.x_um * (turn + h.x_phase_deg.to_radians()).cos();
            shift.y += 1e-3 * h.y_um * (turn + h.y_phase_deg.to_radians()).cos();
        }
        Turned {
            outline: self,
            cos,
            sin,
            top: Direction::new(self, phi),
            bottom: Direction::new(self, phi + PI),
            shift,
        }
    }
}

impl Turned<'_> {
    /// Caliper diameter of the slice at body coordinate `s_mm`, across its own axis, mm.
    pub(crate) fn caliper_mm(&self, s_mm: f64) -> f64 {
        self.support(&self.top, s_mm) + self.support(&self.bottom, s_mm)
    }

    /// Both edges over machine z, mm above the optical axis.
    pub(crate) fn edges(&self, z_mm: f64) -> EdgePair {
        EdgePair { top_mm: self.edge(z_mm, true), bottom_mm: self.edge(z_mm, false) }
    }

    /// Radius of the slice at z in machine direction `angle` (radians from x towards y), about its
    /// own axis, mm.
    pub(crate) fn radius_at(&self, z_mm: f64, angle: f64) -> f64 {
        self.outline.radius_mm(z_mm, angle - self.sin.atan2(self.cos))
    }

    /// Position of the slice's axis, mm along x and y from that of the spindle, without the pose in
    /// front of a camera.
    pub(crate) fn axis_mm(&self, z_mm: f64) -> (f64, f64) {
        let axis = self.axis(z_mm);
        (axis.x, axis.y)
    }

    /// Distance of the slice's axis from the focal plane, mm towards the camera.
    pub(crate) fn axis_y_mm(&self, z_mm: f64) -> f64 {
        self.axis(z_mm).y
    }

    /// Image positions (z, x) of both sides of a corner at body coordinate `s_mm` on both edges,
    /// mm.
    pub(crate) fn corner_seen(&self, s_mm: f64) -> [(f64, f64); 4] {
        let outline = self.outline;
        let seen = |side: f64, top: bool| {
            let point = outline.tilt * DVec2::new(s_mm, self.over_axis(s_mm + side * BESIDE_MM, top));
            (point.x, point.y + outline.shaft.pose.x_mm)
        };
        [seen(-1.0, true), seen(1.0, true), seen(-1.0, false), seen(1.0, false)]
    }

    /// Moves the axis of rotation by an error that does not repeat, mm along x and y.
    #[must_use]
    pub(crate) fn shifted(mut self, x_mm: f64, y_mm: f64) -> Self {
        self.shift += DVec2::new(x_mm, y_mm);
        self
    }

    pub(super) fn edge(&self, z_mm: f64, top: bool) -> f64 {
        let outline = self.outline;
        let pose_x = outline.shaft.pose.x_mm;
        if outline.sin_tilt == 0.0 {
            return pose_x + self.over_axis(z_mm, top);
        }
        let height = |point: DVec2| (outline.tilt * point).y;
        let outer = |best: Option<f64>, x: f64| match best {
            Some(b) if (b > x) == top => Some(b),
            _ => Some(x),
        };
        let outermost = self.crossings(z_mm, top).into_iter().map(height).fold(None, outer);
        pose_x + outermost.unwrap_or_else(|| height(self.on_outline(z_mm, top)))
    }

    /// Light beneath the overhang of a leaning shoulder at z: its inner and outer end, mm above the
    /// optical axis.
    pub(crate) fn gap(&self, z_mm: f64, top: bool) -> Option<[f64; 2]> {
        let outline = self.outline;
        if outline.sin_tilt == 0.0 {
            return None;
        }
        let points = self.crossings(z_mm, top);
        let mut heights: Vec<f64> = points.into_iter().map(|p| (outline.tilt * p).y).collect();
        heights.sort_by(|a, b| if top { b.total_cmp(a) } else { a.total_cmp(b) });
        let pose_x = outline.shaft.pose.x_mm;
        (heights.len() > 2).then(|| [heights[2], heights[1]].map(|x| pose_x + x))
    }

    /// Every point (s, X) at which a tilted body's outline crosses z, where corners are near; empty
    /// where there are no corners.
    fn crossings(&self, z_mm: f64, top: bool) -> Vec<DVec2> {
        let outline = self.outline;
        let (sin, cos) = (outline.sin_tilt, outline.cos_tilt);
        let reach =
            1.1 * (sin.abs() * outline.mean_radii_mm().1 + z_mm.abs() * (1.0 - cos)) / cos + BESIDE_MM;
        let breaks = outline.breaks_mm(z_mm - reach, z_mm + reach);
        let mut found = Vec::new();
        if breaks.is_empty() {
            return found;
        }
        let place = |s: f64| s * cos - self.over_axis(s, top) * sin - z_mm;
        let mut low = (z_mm - reach, place(z_mm - reach));
        for s in breaks.into_iter().map(Some).chain([None]) {
            let end = s.map_or(z_mm + reach, |s| s - BESIDE_MM);
            let high = (end, place(end));
            if (low.1 <= 0.0) != (high.1 <= 0.0) {
                let s = root(place, low, high);
                found.push(DVec2::new(s, self.over_axis(s, top)));
            }
            let Some(s) = s else { break };
            low = (s + BESIDE_MM, place(s + BESIDE_MM));
            if (high.1 <= 0.0) != (low.1 <= 0.0) {
                // On the face of the shoulder.
                found.push(DVec2::new(s, (s * cos - z_mm) / sin));
            }
        }
        found
    }

    /// The outline's point (s, X) of a tilted body at z, far from corners.
    fn on_outline(&self, z_mm: f64, top: bool) -> DVec2 {
        let outline = self.outline;
        let radius = mean_radius(&outline.shaft.profile, z_mm);
        let mut point = DVec2::new(z_mm, if top { radius } else { -radius });
        for _ in 0..TILT_STEPS {
            let before = point.x;
            point.x = (z_mm + point.y * outline.sin_tilt) / outline.cos_tilt;
            point.y = self.over_axis(point.x, top);
            if (point.x - before).abs() < TILT_STILL_MM {
                return point;
            }
        }
        // A face too steep for the iteration.
        let place = |s: f64| s * outline.cos_tilt - self.over_axis(s, top) * outline.sin_tilt - z_mm;
        let reach = 1.1 * outline.mean_radii_mm().1 * outline.sin_tilt.abs();
        let [low, high] = [z_mm - reach, z_mm + reach].map(|s| (s, place(s)));
        let s = root(place, low, high);
        DVec2::new(s, self.over_axis(s, top))
    }

    /// Signed height X(s) of an edge over the axis of rotation.
    fn over_axis(&self, s_mm: f64, top: bool) -> f64 {
        let (axis, secant) = (self.axis(s_mm).x, self.secant(s_mm));
        if top {
            axis + secant * self.support(&self.top, s_mm)
        } else {
            axis - secant * self.support(&self.bottom, s_mm)
        }
    }

    /// Position of the slice's axis: eccentricity and bow turn with the body, deflection does not.
    pub(super) fn axis(&self, s_mm: f64) -> DVec2 {
        let shaft = &self.outline.shaft;
        let phase = shaft.eccentricity.phase_deg.to_radians();
        let body =
            shaft.eccentricity.amplitude_mm * DVec2::from_angle(phase) + bent::offset(&shaft.bow, s_mm);
        DVec2::new(self.cos, self.sin).rotate(body) + bent::offset(&shaft.deflection, s_mm) + self.shift
    }

    /// Ratio of the height of an upright slice to that of the section perpendicular to the axis,
    /// where the axis slopes in the image plane.
    pub(super) fn secant(&self, s_mm: f64) -> f64 {
        let shaft = &self.outline.shaft;
        if shaft.bow.is_empty() && shaft.deflection.is_empty() {
            return 1.0;
        }
        let bow = DVec2::new(self.cos, self.sin).rotate(bent::slope(&shaft.bow, s_mm));
        bent::secant(bow.x + bent::slope(&shaft.deflection, s_mm).x)
    }

    fn support(&self, direction: &Direction, s_mm: f64) -> f64 {
        let outline = self.outline;
        let mean = outline.mean_radius_mm(s_mm);
        let features = &outline.shaft.features;
        if !(features.helices.is_empty() && features.flats.is_empty() && features.keyways.is_empty()) {
            return Slice::at(outline, s_mm).support(direction);
        }
        if outline.low_mm == 0.0 && outline.high_mm == 0.0 {
            return mean;
        }
        let rows = Rows::at(outline.shaft.texture.as_ref(), s_mm);
        let mut best = f64::NEG_INFINITY;
        for segment in &direction.segments {
            if (mean + outline.high_mm) * segment.cos_near <= best {
                break;
            }
            let ends = segment.texture(&rows);
            let bound = (mean + segment.lobes_high + ends[0].max(ends[1])) * segment.cos_near;
            if bound > best {
                best = best.max(segment.maximum(mean, ends));
            }
        }
        best
    }
}

/// Zero of a function between two points at which it has different signs: regula falsi with the
/// retained end halved (Illinois algorithm).
fn root(f: impl Fn(f64) -> f64, mut low: (f64, f64), mut high: (f64, f64)) -> f64 {
    for _ in 0..ROOT_STEPS {
        let s = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        let value = f(s);
        if !s.is_finite() || value.abs() < ROOT_STILL_MM || (high.0 - low.0).abs() < ROOT_STILL_MM {
            return if s.is_finite() { s } else { 0.5 * (low.0 + high.0) };
        }
        if (value <= 0.0) == (low.1 <= 0.0) {
            (low, high.1) = ((s, value), 0.5 * high.1);
        } else {
            (high, low.1) = ((s, value), 0.5 * low.1);
        }
    }
    0.5 * (low.0 + high.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shaft::{AxisKnot, Shaft};

    /// The upper and lower envelope of discs of radius R centred on the axis: the outline of a
    /// bent, round bar by definition.
    #[test]
    fn edges_of_a_bent_bar_are_the_parallel_curves_of_its_axis() {
        let (length, sagitta, radius) = (150.0_f64, 0.5_f64, 4.0_f64);
        let axis = |z: f64| sagitta * (std::f64::consts::PI * z / length).sin();
        let knots = (0..=1500).map(|i| f64::from(i) * length / 1500.0);
        let deflection: Vec<AxisKnot> =
            knots.map(|z_mm| AxisKnot { z_mm, x_mm: axis(z_mm), y_mm: 0.3 * axis(z_mm) }).collect();
        let shaft = Shaft { deflection, ..Shaft::cylinder(2.0 * radius) };
        let outline = Outline::new(shaft).unwrap();
        let turned = outline.turned(30.0);
        for z in [3.0, 20.0, 40.0, 75.0, 120.0] {
            let disc = |side: f64| {
                let height = |s: f64| axis(s) * side + (radius * radius - (z - s) * (z - s)).max(0.0).sqrt();
                (-20_000..=20_000).map(|i| height(z + f64::from(i) * 1e-5)).fold(f64::MIN, f64::max)
            };
            let edges = turned.edges(z);
            // At the worst place the bar is 0.22 µm wider perpendicular to z than to its axis; the
            // error is a hundredth of that.
            assert!((edges.top_mm - disc(1.0)).abs() < 3e-6, "{z}: {} {}", edges.top_mm, disc(1.0));
            assert!((-edges.bottom_mm - disc(-1.0)).abs() < 3e-6, "{z}");
            let wider = edges.top_mm - edges.bottom_mm - 2.0 * radius;
            let slope = sagitta * std::f64::consts::PI / length * (std::f64::consts::PI * z / length).cos();
            assert!((wider - radius * slope * slope).abs() < 2e-8, "{z}: {wider}");
            assert!((turned.caliper_mm(z) - 2.0 * radius).abs() < 1e-12);
        }
    }
}
