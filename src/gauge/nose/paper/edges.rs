//! Canny's edges of a frame: Gaussian, Sobel, non-maximum suppression, hysteresis over eight
//! neighbours.

use glam::DVec2;
use image::{GrayImage, Luma};
use imageproc::edges::canny;

use super::super::contour::grey_and_level;
use super::super::error::NoseImageError;
use crate::frame::FrameView;
use crate::numerics::robust::median_of;

/// Thresholds of the hysteresis, in Sobel's units at 255 grey values from shadow to light. The
/// paper has none. Blurred by σ an edge reaches 8·255/(σ'·√(2π)) with σ'² = σ² + 1.4² (the
/// detector's own Gaussian): 443 at 1.2 px and 246 at 3 px, the most that is in focus. Half of that
/// passes every edge in focus; noise of 4 grey values stays below 10. The low one is 2.5 times less
/// (J. Canny 1986: two to three times).
const HIGH: f32 = 120.0;
const LOW: f32 = 48.0;

/// The edge image: 255 on edges, 0 elsewhere.
pub(super) fn edge_image(view: &FrameView<'_>) -> Result<GrayImage, NoseImageError> {
    let (grey, level) = grey_and_level(view)?;
    let side = |lit: bool| {
        let values = grey.values.iter().copied().map(f64::from).filter(|v| (*v >= level) == lit);
        // of every sixteenth pixel: levels to a fraction of a grey value
        median_of(values.step_by(16).collect())
    };
    let (dark, light) = (side(false), side(true));
    let image = GrayImage::from_fn(grey.columns as u32, grey.rows as u32, |c, r| {
        let value = f64::from(grey.values[r as usize * grey.columns + c as usize]);
        Luma([(255.0 * (value - dark) / (light - dark)).clamp(0.0, 255.0).round() as u8])
    });
    Ok(canny(&image, LOW, HIGH))
}

/// Places of the edge's pixels, (column, −row).
pub(super) fn places(edges: &GrayImage) -> Vec<DVec2> {
    let on = edges.enumerate_pixels().filter(|(_, _, value)| value.0[0] > 0);
    on.map(|(column, row, _)| DVec2::new(f64::from(column), -f64::from(row))).collect()
}
