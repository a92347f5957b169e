//! The way down from a refused stretch to where the shadow's width levels out.

use super::{AxisScratch, FLOOR_PX, GROWTH, fit};

/// Columns whose mean widths are compared on the way down.
const DESCENT: usize = 8;

impl AxisScratch {
    /// Whether a column has no width any more.
    fn gone(&self, column: usize) -> bool {
        self.refused[column] || !self.departures[column].is_finite()
    }

    /// Extends refused stretches and gaps down the slopes of the shadow's width: matter on both sides at one place leaves the
    /// middle alone, and what hides an edge darkens its neighbours.
    pub(super) fn descend(&mut self) {
        let line = fit(self.blocks.iter().map(|b| (b.x, b.width)), false);
        let taper = line.map_or(0.0, |l| l[1]) * 2.0 / self.departures.len().max(1) as f64;
        let columns = self.departures.len() as isize;
        for step in [1_isize, -1] {
            for column in 0..columns {
                let next = column + step;
                let ends =
                    next >= 0 && next < columns && self.gone(column as usize) && !self.gone(next as usize);
                if ends {
                    self.descend_from(next, step, taper);
                }
            }
        }
    }

    /// Refuses the columns on the way down from one to where the width levels out; none where it does not: that is form.
    fn descend_from(&mut self, from: isize, step: isize, taper: f64) {
        let tapered = taper * (DESCENT as isize * step) as f64;
        let mut at = from;
        for _ in 0..2 * GROWTH / DESCENT {
            let below = at + step * DESCENT as isize;
            let (Some(here), Some(next)) = (self.mean_width(at, step), self.mean_width(below, step)) else {
                return;
            };
            // Down by itself and against the part's taper: a step elsewhere in the field makes the taper's line too steep.
            let fall = (here - next).min(here - next + tapered);
            if fall < FLOOR_PX {
                if at != from {
                    let (low, high) = (from.min(at - step), from.max(at - step));
                    self.refused[low as usize..=high as usize].fill(true);
                }
                return;
            }
            at = below;
        }
    }

    /// Mean width of [`DESCENT`] columns from one on; `None` where they leave the frame or few have one.
    fn mean_width(&self, from: isize, step: isize) -> Option<f64> {
        let last = from + step * (DESCENT as isize - 1);
        let (low, high) = (usize::try_from(from.min(last)).ok()?, usize::try_from(from.max(last)).ok()?);
        let widths = self.widths.get(low..=high)?;
        let (mut sum, mut count) = (0.0, 0.0);
        for width in widths.iter().filter(|w| w.is_finite()) {
            (sum, count) = (sum + f64::from(*width), count + 1.0);
        }
        (count >= 3.0).then(|| sum / count)
    }
}
