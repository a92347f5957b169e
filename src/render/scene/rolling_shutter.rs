//! A rolling shutter: every row of a frame is exposed a line time after the one before it, so that
//! each edge is seen where it stands at the time of its own row.
//!
//! ```text
//! e = e₀(t + τ·n(e))        n(e) the edge's place in the order of readout, τ the line time
//! ```
//!
//! The edges are sampled at times that the fastest motion takes 0.2 rad between, with a polynomial
//! through four of them (2e-5 of an amplitude); the equation is solved by repetition, which gains a
//! factor of speed × line time (below 0.05 rows a row) each time. Left out: an edge that moves by v
//! rows a line time is narrower or wider by that share, 0.4 % at 6 mm/s, 10 µs and 15 µm a pixel.

use super::true_optics::OpticalSetup;
use crate::render::contamination::Rise;
use crate::render::kernel::column_edges::ColumnEdges;
use crate::render::kernel::params::Windows;

/// Phase of the fastest motion between two sampled times, rad.
const STEP_RAD: f64 = 0.2;

/// Least steps over the frame: a carriage moves slopes past the camera, not waves.
const LEAST_STEPS: f64 = 8.0;

/// Repetitions of the equation: 0.05⁵ of a displacement is left.
const REPETITIONS: usize = 5;

/// When the rows of a frame are exposed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LineTimes {
    line_us: f64,
    /// Windows in the order in which they are read.
    read: Windows,
}

impl LineTimes {
    /// The times of a camera's rows; none for a global shutter, and for a flash that falls into
    /// the exposure of every row.
    pub(super) fn of(setup: &OpticalSetup, read: Windows) -> Option<Self> {
        let line_us = setup.nominal.camera.line_time_us;
        (line_us > 0.0 && setup.nominal.motion.strobe.is_none()).then_some(Self { line_us, read })
    }

    /// Time from the exposure of the first row to that of a row of the sensor, which an upper or a
    /// lower edge stands in, µs.
    fn us(&self, sensor_row: f64, upper: bool) -> f64 {
        let left_out = if upper { 0 } else { self.read.skip() };
        self.line_us * (sensor_row - f64::from(self.read.first.row) - f64::from(left_out))
    }
}

/// Edges of a frame in motion, from the time of its first row.
pub(super) struct Moving<'a, F: Fn(f64) -> Vec<ColumnEdges>> {
    pub(super) times: LineTimes,
    /// Sensor row of the edges' row 0.
    pub(super) row0: f64,
    /// Edges at the time of the first row.
    pub(super) first: &'a [ColumnEdges],
    /// Edges some µs later.
    pub(super) later: F,
    /// Largest rate of a motion's phase, rad/µs.
    pub(super) quickest: f64,
}

impl<F: Fn(f64) -> Vec<ColumnEdges>> Moving<'_, F> {
    /// How far the part's edges stand outside their place at the first row's time, at the times of
    /// their own rows, px.
    pub(super) fn displacements(&self) -> Vec<Rise> {
        let sampled = self.sampled();
        let at = |column: usize, e: &ColumnEdges| {
            let top = self.solved(e.top_px, true, |us| sampled.row(us, |node| node[column].top_px));
            let bottom = self.solved(e.bottom_px, false, |us| sampled.row(us, |node| node[column].bottom_px));
            Rise { top_px: e.top_px - top, bottom_px: bottom - e.bottom_px }
        };
        self.first.iter().enumerate().map(|(column, e)| at(column, e)).collect()
    }

    fn solved(&self, first: f64, upper: bool, row_at: impl Fn(f64) -> f64) -> f64 {
        (0..REPETITIONS).fold(first, |row, _| row_at(self.times.us(self.row0 + row, upper)))
    }

    /// Edges over the times of all rows that edges stand in, two steps beyond them.
    fn sampled(&self) -> Sampled {
        let of = |e: &ColumnEdges| {
            [self.times.us(self.row0 + e.top_px, true), self.times.us(self.row0 + e.bottom_px, false)]
        };
        let times = self.first.iter().flat_map(of);
        let (from, to) = times.fold((f64::INFINITY, 0.0_f64), |(a, b), us| (a.min(us), b.max(us)));
        let least = (to - from).max(self.times.line_us) / LEAST_STEPS;
        let step_us = if self.quickest > 0.0 { least.min(STEP_RAD / self.quickest) } else { least };
        let count = ((to - from) / step_us).ceil() as usize + 5;
        let from_us = from - 2.0 * step_us;
        let nodes = (0..count).map(|k| (self.later)(from_us + k as f64 * step_us)).collect();
        Sampled { from_us, step_us, nodes }
    }
}

/// Edges at even times.
struct Sampled {
    from_us: f64,
    step_us: f64,
    nodes: Vec<Vec<ColumnEdges>>,
}

impl Sampled {
    /// A row at a time: the cubic through the four nearest times.
    fn row(&self, us: f64, of: impl Fn(&[ColumnEdges]) -> f64) -> f64 {
        let place = (us - self.from_us) / self.step_us;
        let first = (place.floor() - 1.0).clamp(0.0, (self.nodes.len() - 4) as f64) as usize;
        let t = place - first as f64;
        let weights = [
            -(t - 1.0) * (t - 2.0) * (t - 3.0) / 6.0,
            t * (t - 2.0) * (t - 3.0) / 2.0,
            -t * (t - 1.0) * (t - 3.0) / 2.0,
            t * (t - 1.0) * (t - 2.0) / 6.0,
        ];
        // Relative to the first, so that a place of 2000 rows keeps its last bits.
        let base = of(&self.nodes[first]);
        let four = self.nodes[first..first + 4].iter().zip(weights);
        base + four.map(|(node, w)| w * (of(node) - base)).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::kernel::params::Window;

    #[test]
    fn an_edge_is_seen_where_it_stands_at_its_own_time() {
        let window = |row, rows| Window { row, column: 0, rows, columns: 1 };
        let read = Windows { first: window(100, 300), second: Some(window(800, 200)) };
        let times = LineTimes { line_us: 12.0, read };
        // Row 120 is the 20th, row 810 the 310th: 400 rows between the windows are left out.
        assert_eq!((times.us(120.0, true), times.us(810.0, false)), (240.0, 3720.0));
        let (amplitude, rate) = (3.0, 2e-3);
        let at = |us: f64| amplitude * (rate * us).sin();
        let later = |us| vec![ColumnEdges { top_px: 20.0 + at(us), bottom_px: 710.0 + at(us) }];
        let first = later(0.0);
        let moving = Moving { times, row0: 100.0, first: &first, later, quickest: rate };
        let Rise { top_px, bottom_px } = moving.displacements()[0];
        for (seen, base, upper) in [(20.0 - top_px, 20.0, true), (710.0 + bottom_px, 710.0, false)] {
            let wanted = base + at(times.us(100.0 + seen, upper));
            assert!((seen - wanted).abs() < 1e-4 * amplitude, "{seen} {wanted}");
        }
    }
}
