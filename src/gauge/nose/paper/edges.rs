//! Canny's edges of a frame: Gaussian, Sobel, non-maximum suppression, hysteresis over eight
//! neighbours.

use glam::DVec2;
use image::{GrayImage, Luma};
use imageproc::edges::canny;

use super::super::contour::grey_and_level;
use super::super::error::NoseImageError;
use super::limits::PaperNoseLimits;
use crate::frame::FrameView;
use crate::numerics::robust::median_of;

/// The edge image: 255 on edges, 0 elsewhere.
pub(super) fn edge_image(view: &FrameView<'_>) -> Result<GrayImage, NoseImageError> {
    let limits = PaperNoseLimits::get();
    let (grey, level) = grey_and_level(view)?;
    let side = |lit: bool| {
        let values = grey.values.iter().copied().map(f64::from).filter(|v| (*v >= level) == lit);
        median_of(values.step_by(limits.levels_of.max(1)).collect())
    };
    let (dark, light) = (side(false), side(true));
    let image = GrayImage::from_fn(grey.columns as u32, grey.rows as u32, |c, r| {
        let value = f64::from(grey.values[r as usize * grey.columns + c as usize]);
        Luma([(255.0 * (value - dark) / (light - dark)).clamp(0.0, 255.0).round() as u8])
    });
    let low = limits.canny_low.min(limits.canny_high);
    Ok(canny(&image, low as f32, limits.canny_high as f32))
}

/// Places of the edge's pixels, (column, −row).
pub(super) fn places(edges: &GrayImage) -> Vec<DVec2> {
    let on = edges.enumerate_pixels().filter(|(_, _, value)| value.0[0] > 0);
    on.map(|(column, row, _)| DVec2::new(f64::from(column), -f64::from(row))).collect()
}
