//! Extends a refused stretch to where the width of the shadow levels out: down its flanks, and
//! across the bump of which it is a flank.

use super::centreline::fit;
use super::departures::{AxisScratch, DepartureLimits};
use crate::gauge::limit::limits;

limits! {
    /// How far a local bump extends.
    BumpExtentLimits = "bump_extent";
    /// Columns whose mean widths are compared on the way down: the mean of eight has 0.35 of one
    /// width's noise, and a flank is longer.
    mean_columns: usize = 8;
    /// Widening behind a refused stretch from which on it is a local bump's flank, px: two and a
    /// half times what is tested (`departures.floor_px`). Tuned: see study limits.
    rise_px: f64 = 0.1;
    /// Widening a column, px, above which it is a shoulder of the part: a slope of 17°, steeper
    /// than what adheres ends with. Tuned: see study limits.
    shoulder: f64 = 0.3;
    /// Share of a local bump's height down to which it is one: what is lower is its base. Tuned:
    /// see study limits.
    base: f64 = 0.2;
}

impl AxisScratch {
    /// Whether a column has no width left.
    fn gone(&self, column: usize) -> bool {
        self.refused[column] || !self.departures[column].is_finite()
    }

    /// Extends refused stretches and gaps down the slopes of the shadow's width: contamination on
    /// both sides at one place leaves the middle alone, and what hides an edge darkens its
    /// neighbours.
    pub(crate) fn extend_to_base(&mut self) {
        let line = fit(self.blocks.iter().map(|b| (b.x, b.width)), false);
        let taper = line.map_or(0.0, |l| l[1]) * 2.0 / self.departures.len().max(1) as f64;
        self.extend_all(taper);
        if self.cross_bumps(taper) {
            self.extend_all(taper);
        }
    }

    /// Refuses the rest of local bumps of which a flank is refused: where films on both sides meet,
    /// the middle shows only what they differ in. Gives whether there were any.
    fn cross_bumps(&mut self, taper: f64) -> bool {
        let columns = self.departures.len();
        let (mut from, mut any) = (0, false);
        while from < columns {
            if !self.gone(from) {
                from += 1;
                continue;
            }
            let to = (from..columns).find(|c| !self.gone(*c)).unwrap_or(columns);
            if self.refused[from..to].iter().any(|r| *r) {
                let (a, b) = (from as isize, to as isize - 1);
                any |= self.cross_from(b, a, 1, taper) || self.cross_from(a, b, -1, taper);
            }
            from = to;
        }
        any
    }

    /// Crosses a bump that begins beyond the column `near` of a refused stretch whose other end is
    /// `far`. False where there is none: where the width does not rise, rises like a shoulder,
    /// stays high like a collar, or falls again where the middle departs to the other side, as at a
    /// collar of a tilted part.
    fn cross_from(&mut self, near: isize, far: isize, step: isize, taper: f64) -> bool {
        let departure_limits = DepartureLimits::get();
        let limits = BumpExtentLimits::get();
        let length = (near - far).abs() as f64;
        let (Some(base), Some(beyond)) =
            (self.mean_width(far - step, -step), self.mean_width(near + step, step))
        else {
            return false;
        };
        // A round part's crown rises already before the stretch.
        let before = self.mean_width(far - step * (1 + 2 * limits.mean_columns as isize), -step);
        let Some(slope) = before.map(|before| (base - before) / (2 * limits.mean_columns) as f64) else {
            return false;
        };
        let on_the_way = (length + 1.0 + limits.mean_columns as f64) * (slope - taper * step as f64).max(0.0);
        let rise =
            beyond - base - taper * step as f64 * (length + 1.0 + limits.mean_columns as f64) - on_the_way;
        if rise < limits.rise_px || rise > limits.shoulder * (length + 1.0) {
            return false;
        }
        let side = self.side_of(near, -step);
        let columns = self.departures.len() as isize;
        let mut at = near + step;
        while (at - near).unsigned_abs() < 2 * departure_limits.growth {
            let ahead = at + step * (limits.mean_columns as isize - 1);
            let border = ahead < 0 || ahead >= columns;
            let meets = !border && self.refused[ahead as usize];
            if meets && self.side_of(ahead, step) * side < 0.0 {
                return false;
            }
            let height = self.mean_width(at, step).map(|width| {
                width
                    - base
                    - taper
                        * step as f64
                        * (length + 1.0 + (at - near).abs() as f64 + limits.mean_columns as f64)
            });
            if border
                || meets
                || height.is_some_and(|h| h < (limits.base * rise).max(departure_limits.floor_px))
            {
                let end = ahead.clamp(0, columns - 1);
                self.refused[near.min(end) as usize..=near.max(end) as usize].fill(true);
                return true;
            }
            at += step * limits.mean_columns as isize;
        }
        false
    }

    /// Sum of the departures over the columns at the end of a stretch.
    fn side_of(&self, end: isize, step: isize) -> f32 {
        let limits = BumpExtentLimits::get();
        let columns = (0..2 * limits.mean_columns as isize).map(|k| end + step * k);
        let known = columns.filter_map(|c| self.departures.get(usize::try_from(c).ok()?));
        known.filter(|d| d.is_finite()).sum()
    }

    fn extend_all(&mut self, taper: f64) {
        let columns = self.departures.len() as isize;
        for step in [1_isize, -1] {
            for column in 0..columns {
                let next = column + step;
                let ends =
                    next >= 0 && next < columns && self.gone(column as usize) && !self.gone(next as usize);
                if ends {
                    self.extend_from(next, step, taper);
                }
            }
        }
    }

    /// Refuses the columns on the way down from one to where the width levels out; none where it
    /// does not: that is form.
    fn extend_from(&mut self, from: isize, step: isize, taper: f64) {
        let departure_limits = DepartureLimits::get();
        let limits = BumpExtentLimits::get();
        let tapered = taper * (limits.mean_columns as isize * step) as f64;
        let mut at = from;
        for _ in 0..2 * departure_limits.growth / limits.mean_columns {
            let below = at + step * limits.mean_columns as isize;
            let (Some(here), Some(next)) = (self.mean_width(at, step), self.mean_width(below, step)) else {
                return;
            };
            // Falls both by itself and after subtraction of the taper: a step elsewhere in the
            // field makes the fitted taper too steep.
            let fall = (here - next).min(here - next + tapered);
            if fall < departure_limits.floor_px {
                if at != from {
                    let (low, high) = (from.min(at - step), from.max(at - step));
                    self.refused[low as usize..=high as usize].fill(true);
                }
                return;
            }
            at = below;
        }
    }

    /// Mean width of `mean_columns` columns from one on; `None` where they leave the frame or few
    /// have one.
    fn mean_width(&self, from: isize, step: isize) -> Option<f64> {
        let last = from + step * (BumpExtentLimits::get().mean_columns as isize - 1);
        let (low, high) = (usize::try_from(from.min(last)).ok()?, usize::try_from(from.max(last)).ok()?);
        let widths = self.widths.get(low..=high)?;
        let (mut sum, mut count) = (0.0, 0.0);
        for width in widths.iter().filter(|w| w.is_finite()) {
            (sum, count) = (sum + f64::from(*width), count + 1.0);
        }
        (count >= 3.0).then(|| sum / count)
    }
}

#[cfg(test)]
mod tests;
