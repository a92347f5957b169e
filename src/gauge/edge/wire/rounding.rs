//! Rounding to whole counts that repeats in the edges of a wire.
//!
//! As at other edges ([`crate::gauge::edge::estimation::rounding`]), but both edges, the levels and
//! the blur are one fit: the error b_k of pixel k moves the width by Σ g_k b_k, g = w_k·(H⁻¹ J_k)
//! of one column's six equations (a level wire repeats the same pixels in every column). Pixels of
//! one flat level share their error, others have their own:
//!
//! ```text
//! u² = Σ_levels (Σ_k g_k)²·r(σ)/(1 + its run) + Σ_others g_k²·r(σ_k)/(1 + counts swept)
//! ```

use nalgebra::{Matrix6, Vector6};

use crate::gauge::edge::estimation::rounding::{RoundingLimits, repeated_variance, rows_swept};
use crate::gauge::edges::Edge;
use crate::gauge::limit::limits;

limits! {
    /// Which pixels of a wire are flat.
    WireRoundingLimits = "wire_rounding";
    /// Share of the light up to which, and from which on, a pixel has a flat level, and so shares
    /// its error of rounding with all others of that level. Tuned: see study limits.
    flat_share: f64 = 0.02;
}

/// A pixel in the equations of its column.
pub(crate) struct WirePixel {
    /// Weight, 1/counts².
    pub(crate) weight: f64,
    /// Share of light from above and from below.
    pub(crate) light: [f64; 2],
    /// Derivatives by shadow, light above and below, blur, upper and lower edge.
    pub(crate) by: Vector6<f64>,
}

/// Rounding of a wire's grey values.
pub(crate) struct WireRounding {
    /// Step of the grey scale, counts.
    pub(crate) step: f64,
    /// Noise in shadow and light, in steps.
    pub(crate) noise: [f64; 2],
    /// Steps that the shadow's and both lights' levels run over along the wire.
    pub(crate) runs: [f64; 3],
    /// Whether both lights are one level.
    pub(crate) alike: bool,
}

impl WireRounding {
    /// Moves the repeating variance from the edges' own to their shared uncertainty; returns the
    /// standard uncertainty of either edge that repeats, px. `equations` gives those of so many
    /// columns.
    pub(crate) fn state(
        &self,
        equations: impl FnOnce(usize) -> Vec<Vec<WirePixel>>,
        lines: [&mut [Edge]; 2],
    ) -> f64 {
        let limits = RoundingLimits::get();
        if self.noise.iter().all(|sd| *sd > limits.dithered) {
            return 0.0;
        }
        let (mut width, mut share, mut count) = (0.0, 0.0, 0.0);
        let [top, bottom] = lines;
        let swept = 0.5 * (rows_swept(top) + rows_swept(bottom));
        for pixels in equations(limits.looked_at) {
            if let Some((variance, part)) = self.of_column(&pixels, swept) {
                (width, share, count) = (width + variance, share + part, count + 1.0);
            }
        }
        if count == 0.0 {
            return 0.0;
        }
        let (u2, share) = (0.5 * width / count, (share / count).clamp(0.0, 1.0));
        for edge in top.iter_mut().chain(bottom).filter(|e| e.is_usable()) {
            edge.u_own_px *= (1.0 - share).sqrt() as f32;
            edge.u_shared_px = (f64::from(edge.u_shared_px).powi(2) + u2).sqrt() as f32;
        }
        u2.sqrt()
    }

    /// Variance of the width, px², and the share of what repeats in the pixels' own variance.
    fn of_column(&self, pixels: &[WirePixel], swept: f64) -> Option<(f64, f64)> {
        let mut normal = Matrix6::zeros();
        pixels.iter().for_each(|p| normal += p.by * p.by.transpose() * p.weight);
        let inverse = normal.try_inverse()?;
        let flat_share = WireRoundingLimits::get().flat_share;
        let (mut flat, mut others, mut repeated, mut all) = ([0.0_f64; 3], 0.0, 0.0, 0.0);
        for p in pixels {
            let lever = inverse * p.by * p.weight;
            let g = lever[5] - lever[4];
            let light = (p.light[0] + p.light[1]).clamp(0.0, 1.0);
            let sd = self.noise[0] + light * (self.noise[1] - self.noise[0]);
            let r = repeated_variance(sd) * self.step.powi(2);
            match light {
                l if l < flat_share => flat[0] += g,
                l if l > 1.0 - flat_share => flat[usize::from(p.light[1] > p.light[0]) + 1] += g,
                _ => others += g * g * r / (1.0 + swept * p.by[5].abs().max(p.by[4].abs()) / self.step),
            }
            repeated += g * g * r;
            all += g * g * (sd * sd + 1.0 / 12.0) * self.step.powi(2);
        }
        let level = |k: usize, zone: usize| {
            flat[k].powi(2) * repeated_variance(self.noise[zone]) * self.step.powi(2) / (1.0 + self.runs[k])
        };
        let lights = if self.alike {
            let r = repeated_variance(self.noise[1]) * self.step.powi(2);
            (flat[1] + flat[2]).powi(2) * r / (1.0 + self.runs[1].min(self.runs[2]))
        } else {
            level(1, 1) + level(2, 1)
        };
        Some((level(0, 0) + lights + others, repeated / all.max(f64::MIN_POSITIVE)))
    }
}
