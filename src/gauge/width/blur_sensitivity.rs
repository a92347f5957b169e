//! Uncertainty of a width by that of the blur.
//!
//! At one sub-pixel phase position and blur are estimated together: with the information matrix I
//! of (x, σ) a blur off by δ moves the position by −δ·I_xσ/I_xx. With equal noise on both sides
//! this changes its sign from phase to phase, and only a level edge keeps any of it; photon noise,
//! which gives the dark end of the flank more weight, leaves some everywhere. The variance of the
//! blur is u_σ² = 1/Σ(I_σσ − I_xσ²/I_xx) over the columns that it is estimated from.

use crate::gauge::edge::estimation::blur;
use crate::gauge::edge::model::gaussian::{EdgeSample, edge_samples};
use crate::gauge::edges::{Edge, FrameEdges};
use crate::gauge::limit::limits;

limits! {
    /// Where the weight of the blur is evaluated.
    BlurSensitivityLimits = "blur_sensitivity";
    /// Columns whose phases are evaluated: those of an edge that is not level are then a 64th of a
    /// pixel apart in the mean.
    looked_at: usize = 64;
}

/// Most pixels either side of the edge, the length of an array: three standard deviations of the
/// widest blur, 8 px.
const REACH: i32 = 24;

/// Uncertainty of the blur at a column over that of its mean along the field: a line through the
/// blocks' blurs is known there to √(1 + 12·t²), t from −½ to ½.
pub(crate) fn trend_factor(column_px: f64, columns: usize) -> f64 {
    let t = (column_px + 0.5) / columns.max(1) as f64 - 0.5;
    (1.0 + 12.0 * t * t).sqrt()
}

/// Standard uncertainty of the mean width over some columns by the blurs of both edges, px, and the
/// larger uncertainty of these blurs, px.
pub(crate) fn u_blur_px(edges: &FrameEdges, used: &[usize]) -> (f64, f64) {
    let sides = [(0, &edges.top), (1, &edges.bottom)].map(|(side, line)| of_side(edges, side, line, used));
    let [a, b] = sides;
    let middle = used.iter().map(|c| *c as f64).sum::<f64>() / used.len().max(1) as f64;
    let factor = trend_factor(middle, edges.columns());
    (factor * a.0.hypot(b.0), factor * a.1.max(b.1))
}

fn of_side(edges: &FrameEdges, side: usize, line: &[Edge], used: &[usize]) -> (f64, f64) {
    let limits = BlurSensitivityLimits::get();
    let figures = &edges.figures;
    let (dark, contrast) = (figures.dark[side], figures.light[side] - figures.dark[side]);
    let variance = figures.noise.map(|n| n * n);
    let (mut lever, mut information, mut count) = (0.0, 0.0, 0.0);
    let sigma_px = figures.sigma_px[side];
    // beyond seven standard deviations the squares of the derivatives are below 1e-20 of their sum
    let reach = ((7.0 * sigma_px).ceil() as i32).clamp(1, REACH);
    let mut samples = [EdgeSample::default(); 2 * REACH as usize + 1];
    let samples = &mut samples[..2 * reach as usize + 1];
    for column in used.iter().step_by(used.len().div_ceil(limits.looked_at).max(1)) {
        let row = line[*column].row_px;
        // From the shadow to the light: upwards at the upper edge.
        let phase = if side == 0 { row.round() - row } else { row - row.round() };
        edge_samples(f64::from(-reach), phase, sigma_px, samples);
        let (mut xx, mut xs, mut ss) = (0.0, 0.0, 0.0);
        for s in samples.iter() {
            let weight =
                contrast * contrast / (variance[0] + (variance[1] - variance[0]) * s.value).max(1e-12);
            xx += weight * s.by_position * s.by_position;
            xs += weight * s.by_position * s.by_sigma;
            ss += weight * s.by_sigma * s.by_sigma;
        }
        if xx > 0.0 {
            lever -= xs / xx;
            information += ss - xs * xs / xx;
            count += 1.0;
        }
    }
    if !(information > 0.0 && dark.is_finite()) {
        return (0.0, 0.0);
    }
    let estimated_from = blur::estimated_from(edges.columns()) as f64;
    let u_sigma = (information / count * estimated_from).recip().sqrt();
    ((lever / count).abs() * u_sigma, u_sigma)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauge::edges::EdgeState;
    use crate::gauge::edges::FrameFigures;

    fn frame(row: impl Fn(usize) -> f64, noise: [f64; 2]) -> FrameEdges {
        let edge =
            |row_px| Edge { row_px, u_own_px: 0.01, u_shared_px: 0.0, chi2: 1.0, state: EdgeState::Good };
        let figures = FrameFigures {
            sigma_px: [0.6; 2],
            dark: [10.0; 2],
            light: [210.0; 2],
            noise,
            ..FrameFigures::default()
        };
        let (top, bottom) = (0..256).map(|c| (edge(row(c)), edge(100.0 + row(c)))).unzip();
        FrameEdges { top, bottom, figures, ..FrameEdges::default() }
    }

    #[test]
    fn blur_moves_a_level_edge_between_two_pixels_symmetrically_not_at_all_and_all_phases_hardly() {
        let all: Vec<usize> = (0..256).collect();
        // On a pixel's middle and on its border everything is symmetric.
        for symmetric in [20.0, 20.5] {
            assert!(u_blur_px(&frame(|_| symmetric, [2.0; 2]), &all).0 < 1e-12);
        }
        let (level, u_sigma) = u_blur_px(&frame(|_| 20.25, [2.0; 2]), &all);
        let travelling = u_blur_px(&frame(|c| 20.0 + c as f64 / 256.0, [2.0; 2]), &all).0;
        assert!(level > 1e-6 && travelling < 0.05 * level, "{level} {travelling}");
        // A hundredth of the contrast in noise, 256 columns: the blur is known to about a per mille
        // of a pixel.
        assert!((3e-4..3e-3).contains(&u_sigma), "{u_sigma}");
        let noisier = u_blur_px(&frame(|_| 20.25, [4.0; 2]), &all);
        assert!((noisier.0 / level - 2.0).abs() < 1e-9 && (noisier.1 / u_sigma - 2.0).abs() < 1e-9);
    }
}
