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
    let factor = bias_per_curvature(sigma_px);
    // y'' and slope of evenly spaced points: fixed weights, Σ w·y with w = t² − mean(t²).
    let arm = limits.arm as f64;
    let n = 2.0 * arm + 1.0;
    let mean_square = arm * (arm + 1.0) / 3.0;
    let fourth = (arm * (arm + 1.0) * (3.0 * arm * arm + 3.0 * arm - 1.0)) / 15.0;
    let spread = n * (fourth - mean_square * mean_square);
    for (middle, window) in line.windows(2 * limits.arm + 1).enumerate() {
        if window.iter().any(|e| !e.is_usable()) {
            continue;
        }
        let base = window[limits.arm].row_px;
        let (mut bend, mut slope, mut noise) = (0.0, 0.0, 0.0);
        for (k, edge) in window.iter().enumerate() {
            let t = k as f64 - arm;
            bend += (t * t - mean_square) * (edge.row_px - base);
            slope += t * (edge.row_px - base);
            noise += f64::from(edge.u_own_px).powi(2);
        }
        let second = 2.0 * bend / spread;
        let u_second = 2.0 * (noise / n / spread).sqrt();
        if second.abs() > limits.significant * u_second {
            let tan = slope / (n * mean_square);
            bias[middle + limits.arm] = second / (1.0 + tan * tan) * factor;
        }
    }
    bias
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
}
