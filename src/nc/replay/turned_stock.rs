//! The bar as a program leaves it, move by move: radii at places along Z.
//!
//! A nose that moves straight sweeps a convex region; where it passes a place on the axis, what is
//! left there is no thicker than the region's lowest point. Nothing of how the program was made is
//! used.

use super::convex::Convex;
use super::event::Point;

/// Radii of a bar at the middles of equal steps along Z.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TurnedStock {
    from_mm: f64,
    step_mm: f64,
    radius_mm: Vec<f64>,
}

/// Overlap up to which a rapid merely touches, mm: rounding of a program's numbers.
const TOUCH_MM: f64 = 2e-3;

impl TurnedStock {
    /// A bar between two Z, mm, with the step of its places.
    pub(crate) fn bar((from_mm, to_mm): (f64, f64), radius_mm: f64, step_mm: f64) -> Self {
        let count = ((to_mm - from_mm) / step_mm).round().max(1.0) as usize;
        Self { from_mm, step_mm: (to_mm - from_mm) / count as f64, radius_mm: vec![radius_mm; count] }
    }

    /// Places (Z, radius), mm.
    pub(crate) fn places(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.radius_mm.iter().enumerate().map(|(i, r)| (self.z_mm(i), *r))
    }

    /// Step of the places, mm.
    pub(crate) fn step_mm(&self) -> f64 {
        self.step_mm
    }

    fn z_mm(&self, i: usize) -> f64 {
        self.from_mm + (i as f64 + 0.5) * self.step_mm
    }

    /// Cuts by a move in feed; returns the largest depth along the radius and its Z.
    pub(crate) fn cut(&mut self, tool: &Convex, from: Point, to: Point) -> Option<(f64, f64)> {
        let mut deepest: Option<(f64, f64)> = None;
        for (i, low) in self.lowest(tool, from, to) {
            let depth = self.radius_mm[i] - low.max(0.0);
            if depth > 0.0 {
                self.radius_mm[i] = low.max(0.0);
                if deepest.is_none_or(|(most, _)| depth > most) {
                    deepest = Some((depth, self.z_mm(i)));
                }
            }
        }
        deepest
    }

    /// Z at which a move in rapid touches, and by how much, mm.
    pub(crate) fn touched(&self, tool: &Convex, from: Point, to: Point) -> Option<(f64, f64)> {
        let depth = |(i, low): (usize, f64)| (self.radius_mm[i] - low, self.z_mm(i));
        let deepest = self.lowest(tool, from, to).into_iter().map(depth).max_by(|a, b| a.0.total_cmp(&b.0));
        deepest.filter(|(depth, _)| *depth > TOUCH_MM)
    }

    /// Places that a move passes, with the lowest point of the swept region there.
    fn lowest(&self, tool: &Convex, from: Point, to: Point) -> Vec<(usize, f64)> {
        let swept = tool.swept((from.z, 0.5 * from.x), (to.z, 0.5 * to.x));
        let ((left, _), (right, _)) = swept.bounds();
        let number = |z: f64| ((z - self.from_mm) / self.step_mm - 0.5).ceil().max(0.0) as usize;
        let (first, last) = (number(left), number(right).min(self.radius_mm.len()));
        (first..last).filter_map(|i| Some((i, swept.lowest_at(self.z_mm(i))?))).collect()
    }
}
