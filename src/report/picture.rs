//! Frames as small grey pictures.
//!
//! In: a view of a frame, the part of it, the step from pixel to pixel. Out: 8-bit grey values
//! between the frame's dark and light, as PNG.

use std::io::Cursor;

use image::{GrayImage, ImageFormat, Luma};

use crate::frame::FrameView;

/// Every so many pixels the grey values are looked at for their range: some thousand values of any
/// frame of a gauge.
const SAMPLED: usize = 7;

/// Grey values to 8 bit, between the frame's 0.1 % and 99.9 % quantiles.
pub(super) struct Stretch {
    low: f32,
    scale: f32,
}

impl Stretch {
    pub(super) fn of(view: &FrameView<'_>) -> Self {
        let mut values: Vec<f32> = (0..view.rows())
            .step_by(SAMPLED)
            .flat_map(|r| (0..view.columns()).step_by(SAMPLED).filter_map(move |c| view.get(r, c)))
            .filter(|v| v.is_finite())
            .collect();
        values.sort_by(f32::total_cmp);
        let at = |share: f64| {
            values.get(((values.len() as f64 * share) as usize).min(values.len().saturating_sub(1))).copied()
        };
        let (low, high) = (at(0.001).unwrap_or(0.0), at(0.999).unwrap_or(255.0));
        Self { low, scale: 245.0 / (high - low).max(1.0) }
    }

    fn grey(&self, counts: f32) -> u8 {
        ((counts - self.low) * self.scale).clamp(0.0, 255.0) as u8
    }
}

/// Every step-th pixel of a part of the frame: from (row, column), of size (rows, columns).
pub(super) fn picture(
    view: &FrameView<'_>,
    stretch: &Stretch,
    from: (usize, usize),
    size: (usize, usize),
    step: usize,
) -> GrayImage {
    let (rows, columns) = (size.0.div_ceil(step), size.1.div_ceil(step));
    GrayImage::from_fn(columns as u32, rows as u32, |c, r| {
        let (row, column) = (from.0 + r as usize * step, from.1 + c as usize * step);
        Luma([view.get(row, column).map_or(0, |v| stretch.grey(v))])
    })
}

/// The whole frame, each side at most so many px, each pixel the mean of those it stands for: so
/// that noise does not pass for contamination.
pub(super) fn thumbnail(view: &FrameView<'_>, side_px: usize) -> GrayImage {
    let step = view.rows().max(view.columns()).div_ceil(side_px.max(1)).max(1);
    let stretch = Stretch::of(view);
    let (rows, columns) = (view.rows().div_ceil(step), view.columns().div_ceil(step));
    GrayImage::from_fn(columns as u32, rows as u32, |c, r| {
        let (row, column) = (r as usize * step, c as usize * step);
        let block = (row..row + step).flat_map(|r| (column..column + step).map(move |c| (r, c)));
        let (sum, count) = block
            .filter_map(|(r, c)| view.get(r, c))
            .filter(|v| v.is_finite())
            .fold((0.0_f32, 0.0_f32), |(sum, count), v| (sum + v, count + 1.0));
        Luma([if count > 0.0 { stretch.grey(sum / count) } else { 0 }])
    })
}

/// A picture as PNG.
///
/// # Errors
/// Where it cannot be encoded, as text.
pub(super) fn encode(image: &GrayImage) -> Result<Vec<u8>, String> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Png).map_err(|e| e.to_string())?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Buffer, Frame, FrameMeta, PixelFormat};

    #[test]
    fn a_thumbnail_keeps_to_its_size_and_shows_the_shadow() {
        let pixels = (0..100 * 1000).map(|i| if (40..60).contains(&(i / 1000)) { 10 } else { 200 }).collect();
        let frame =
            Frame::new(Buffer::U8(pixels), PixelFormat::Mono8, 100, 1000, FrameMeta::default()).unwrap();
        let small = thumbnail(&frame.view(), 480);
        assert_eq!(small.dimensions(), (334, 34));
        assert!(small.get_pixel(100, 16).0[0] < 20 && small.get_pixel(100, 2).0[0] > 200);
        assert_eq!(&encode(&small).unwrap()[1..4], b"PNG");
    }
}
