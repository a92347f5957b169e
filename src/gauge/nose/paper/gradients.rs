//! The smaller image and its gradients: level-line angle and size of every pixel.

use std::f64::consts::TAU;

use glam::DVec2;
use image::GrayImage;

use super::false_alarms::gradient_threshold;
use super::limits::PaperNoseLimits;

/// Gradients of the smaller image: level-line angle and size; no angle where the gradient is small.
pub(super) struct Gradients {
    pub(super) angle: Vec<Option<f32>>,
    pub(super) size: Vec<f32>,
    pub(super) columns: usize,
    pub(super) rows: usize,
}

/// The image at 80 %: every edge pixel's light spread by the Gaussian, row by row.
fn smaller(edges: &GrayImage) -> Vec<f32> {
    let limits = PaperNoseLimits::get();
    let (scale, sigma) = (limits.scale, limits.smooth_px);
    let (columns, rows) = scaled(edges.dimensions());
    let mut out = vec![0.0_f32; columns * rows];
    let weight = |from: usize, to: u32| {
        let off = from as f64 / scale - f64::from(to);
        (-0.5 * (off / sigma).powi(2)).exp() / (sigma * TAU.sqrt())
    };
    let near = |at: u32, most: usize| {
        let (low, high) =
            (scale * (f64::from(at) - limits.reach_px), scale * (f64::from(at) + limits.reach_px));
        (low.ceil().max(0.0) as usize)..=(high.floor() as usize).min(most - 1)
    };
    for (column, row, value) in edges.enumerate_pixels().filter(|(_, _, value)| value.0[0] > 0) {
        for r in near(row, rows) {
            let of_row = f64::from(value.0[0]) * weight(r, row);
            for c in near(column, columns) {
                out[r * columns + c] += (of_row * weight(c, column)) as f32;
            }
        }
    }
    out
}

fn scaled((columns, rows): (u32, u32)) -> (usize, usize) {
    let by = |n: u32| ((f64::from(n) * PaperNoseLimits::get().scale).floor() as usize).max(2);
    (by(columns), by(rows))
}

/// Angle between two directions, rad.
pub(super) fn apart(a: f64, b: f64) -> f64 {
    let off = (a - b).rem_euclid(TAU);
    off.min(TAU - off)
}

impl Gradients {
    /// The gradients over 2 × 2 pixels of an edge image at 80 %.
    pub(super) fn of(edges: &GrayImage) -> Self {
        let image = smaller(edges);
        let limits = PaperNoseLimits::get();
        let (columns, rows) = scaled(edges.dimensions());
        let threshold = gradient_threshold(limits.grey_error, limits.tolerance_deg.to_radians()) as f32;
        let (mut angle, mut sizes) = (vec![None; image.len()], vec![0.0; image.len()]);
        for row in 0..rows - 1 {
            for column in 0..columns - 1 {
                let at = row * columns + column;
                let (a, b, c, d) = (image[at], image[at + 1], image[at + columns], image[at + columns + 1]);
                let (x, y) = (0.5 * (b + d - a - c), 0.5 * (c + d - a - b));
                sizes[at] = x.hypot(y);
                // the direction of the line of equal grey, rows downwards
                angle[at] = (sizes[at] > threshold).then(|| x.atan2(-y));
            }
        }
        Self { angle, size: sizes, columns, rows }
    }

    /// Place of a pixel, (column, row).
    pub(super) fn place(&self, at: usize) -> DVec2 {
        DVec2::new((at % self.columns) as f64, (at / self.columns) as f64)
    }

    /// Level-line angle of a pixel, rad; 0 where it has none.
    pub(super) fn angle_of(&self, at: usize) -> f64 {
        f64::from(self.angle[at].unwrap_or(0.0))
    }

    /// Whether a pixel has an angle, and that within `tau` of another one.
    pub(super) fn is_aligned(&self, at: usize, angle: f64, tau: f64) -> bool {
        self.angle[at].is_some_and(|a| apart(f64::from(a), angle) <= tau)
    }
}
