//! The bias of a curved edge.
//!
//! Blur averages a curved edge along its tangent: y(x) becomes y + ½·y''·(σ² + W²/12), σ the blur
//! and W = 1 px the column's width; with slope y' the blur's share along the column is y''·cos²β. A
//! dark disc's edge moves towards its centre, by (σ² + 1/12)/2R.

use super::reused::Reused;
use crate::gauge::edges::Edge;
use crate::gauge::limit::limits;

limits! {
    /// When an edge is curved.
    CurvatureLimits = "curvature_bias";
    /// Columns either side of the parabola that gives y'': over 25 columns noise of 0.02 px gives
    /// it to 0.0002/px, which moves an edge of a blur of 1 px by 0.0001 px.
    arm: usize = 12;
    /// Standard uncertainties up to which a curvature is noise, and not corrected: 6·10⁻⁵ of
    /// straight edges have more.
    significant: f64 = 4.0;
}

/// ½(σ² + 1/12), px²: the bias a unit of y'' gives.
pub(crate) fn bias_per_curvature(sigma_px: f64) -> f64 {
    0.5 * (sigma_px * sigma_px + 1.0 / 12.0)
}

/// Bias of each edge of a line, px, to be subtracted from its row; 0 where the edge is straight or
/// its curvature not significant.
pub(crate) fn curvature_bias(line: &[Edge], sigma_px: f64) -> Reused<f64> {
    let limits = CurvatureLimits::get();
    let mut bias: Reused<f64> = std::iter::repeat_n(0.0, line.len()).collect();
    let parabola = Parabola::over(limits.arm);
    let factor = bias_per_curvature(sigma_px);
    let mut from = 0;
    for run in line.split(|edge| !edge.is_usable()) {
        if run.len() >= parabola.length {
            parabola.along(run, limits.significant, |middle, second, tan| {
                bias[from + middle] = second / (1.0 + tan * tan) * factor;
            });
        }
        from += run.len() + 1;
    }
    bias
}

/// The least-squares parabola through evenly spaced points.
struct Parabola {
    /// Points.
    length: usize,
    /// Σt², over the points' places t about their middle.
    squares: f64,
    /// Σ(t² − mean(t²))².
    spread: f64,
}

impl Parabola {
    /// Over so many points on each side of its middle.
    fn over(arm: usize) -> Self {
        let (length, arm) = (2 * arm + 1, arm as f64);
        let n = length as f64;
        let mean_square = arm * (arm + 1.0) / 3.0;
        let fourth = arm * (arm + 1.0) * (3.0 * arm * arm + 3.0 * arm - 1.0) / 15.0;
        Self { length, squares: n * mean_square, spread: n * (fourth - mean_square * mean_square) }
    }

    /// Passes (place of the middle, y'', y') of every window of a run whose y'' is significant.
    fn along(&self, run: &[Edge], significant: f64, mut found: impl FnMut(usize, f64, f64)) {
        // Sums over a block carry 1e-9 of rounding where its rows span 1e3 px: 1e-14/px of y''.
        let block = 5 * self.length;
        for from in (0..=run.len() - self.length).step_by(block) {
            let to = (from + block + self.length - 1).min(run.len());
            self.along_block(&run[from..to], significant, |middle, second, tan| {
                found(from + middle, second, tan);
            });
        }
    }

    /// As [`Self::along`]: moments of a window are differences of sums from the block's first edge
    /// on, about whose row and place they are taken, so that rounding is that of a block's numbers.
    fn along_block(&self, block: &[Edge], significant: f64, mut found: impl FnMut(usize, f64, f64)) {
        let sums = moments(block);
        let (n, arm) = (self.length as f64, self.length / 2);
        for (first, window) in sums.windows(self.length + 1).enumerate() {
            let (to, from) = (window[self.length], window[0]);
            let (y, ky, kky, noise) = (to.0 - from.0, to.1 - from.1, to.2 - from.2, to.3 - from.3);
            let middle = (first + arm) as f64;
            let ty = ky - middle * y;
            let bend = kky - middle * (ky + ty) - self.squares / n * y;
            let second = 2.0 * bend / self.spread;
            let u_second_squared = 4.0 * noise / n / self.spread;
            if second * second > significant * significant * u_second_squared {
                found(first + arm, second, ty / self.squares);
            }
        }
    }
}

/// Σy, Σk·y, Σk²·y and Σu² of the first 0, 1, 2, … edges of a block: y from the first one's row, k
/// their places, u their own standard uncertainties.
fn moments(block: &[Edge]) -> Reused<(f64, f64, f64, f64)> {
    let base = block[0].row_px;
    let mut sum = (0.0, 0.0, 0.0, 0.0);
    let next = |(k, edge): (usize, &Edge)| {
        let (k, y) = (k as f64, edge.row_px - base);
        sum = (sum.0 + y, sum.1 + k * y, sum.2 + k * k * y, sum.3 + f64::from(edge.u_own_px).powi(2));
        sum
    };
    std::iter::once((0.0, 0.0, 0.0, 0.0)).chain(block.iter().enumerate().map(next)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauge::edges::EdgeState;

    fn edge(row_px: f64) -> Edge {
        Edge { row_px, u_own_px: 1e-3, u_shared_px: 0.0, chi2: 1.0, state: EdgeState::Good }
    }

    #[test]
    fn a_disc_is_corrected_by_the_closed_form_and_a_line_left_alone() {
        let (radius, sigma) = (400.0_f64, 1.5);
        let disc: Vec<Edge> =
            (0..61).map(|c| edge(500.0 - (radius * radius - (f64::from(c) - 30.0).powi(2)).sqrt())).collect();
        let expected = (sigma * sigma + 1.0 / 12.0) / (2.0 * radius);
        let found = curvature_bias(&disc, sigma)[30];
        assert!((found / expected - 1.0).abs() < 2e-3, "{found} {expected}");
        let line: Vec<Edge> = (0..61).map(|c| edge(3.0 + 0.3 * f64::from(c))).collect();
        assert!(curvature_bias(&line, sigma).iter().all(|b| *b == 0.0));
    }

    /// By the parabola of every window on its own: weights t² − mean(t²) and t.
    #[test]
    fn sums_over_blocks_give_what_each_window_gives_and_gaps_part_runs() {
        let (arm, sigma) = (CurvatureLimits::get().arm, 0.9);
        let wave = |c: usize| 700.0 + 0.4 * c as f64 + 5.0 * (c as f64 / 40.0).sin();
        let mut line: Vec<Edge> = (0..700).map(|c| edge(wave(c))).collect();
        for gap in [0, 90, 91, 300] {
            line[gap].state = EdgeState::Gap(crate::profile::Reason::NoEdge);
            line[gap].row_px = f64::NAN;
        }
        let found = curvature_bias(&line, sigma);
        let t = |k: usize| k as f64 - arm as f64;
        let squares: f64 = (0..=2 * arm).map(|k| t(k).powi(2)).sum();
        let mean = squares / (2 * arm + 1) as f64;
        let spread: f64 = (0..=2 * arm).map(|k| (t(k).powi(2) - mean).powi(2)).sum();
        for middle in 0..line.len() {
            let window = line.get(middle.wrapping_sub(arm)..=middle + arm);
            let expected = window.filter(|w| w.iter().all(Edge::is_usable)).map_or(0.0, |window| {
                let sum = |of: &dyn Fn(usize) -> f64| {
                    (0..window.len()).map(|k| of(k) * (window[k].row_px - window[arm].row_px)).sum::<f64>()
                };
                let (second, tan) = (2.0 * sum(&|k| t(k).powi(2) - mean) / spread, sum(&t) / squares);
                let u_second = 2.0 * 1e-3 / spread.sqrt();
                let significant = second.abs() > CurvatureLimits::get().significant * u_second;
                if significant { second / (1.0 + tan * tan) * bias_per_curvature(sigma) } else { 0.0 }
            });
            assert!((found[middle] - expected).abs() < 1e-12, "{middle}: {} {expected}", found[middle]);
        }
    }
}
