//! Reference line and border of the land over the image.

use glam::DVec2;

use crate::frame::FrameView;

/// Colours as those of `tool nose`: what is nominal in blue, what is measured in orange.
const REFERENCE: [u8; 3] = [0, 114, 178];
const LAND: [u8; 3] = [230, 159, 0];

/// An RGB PNG; `places` are pairs of reference and border, (column, row).
///
/// # Errors
/// Where the encoder refuses it, as text.
pub(super) fn overlay(view: &FrameView<'_>, places: &[[DVec2; 2]]) -> Result<Vec<u8>, String> {
    let (rows, columns) = (view.rows(), view.columns());
    let value = |k: usize| view.get(k / columns, k % columns).unwrap_or(0.0);
    let most = (0..rows * columns).map(value).fold(1.0_f32, f32::max);
    let grey = |k: usize| (255.0 * value(k) / most).clamp(0.0, 255.0) as u8;
    let mut pixels: Vec<u8> = (0..rows * columns).flat_map(|k| [grey(k); 3]).collect();
    let mut dot = |p: DVec2, colour: [u8; 3]| {
        let p = p.round();
        if p.x >= 0.0 && p.y >= 0.0 && p.x < columns as f64 && p.y < rows as f64 {
            let at = 3 * (p.y as usize * columns + p.x as usize);
            pixels[at..at + 3].copy_from_slice(&colour);
        }
    };
    for pair in places.windows(2) {
        for (which, colour) in [(0, REFERENCE), (1, LAND)] {
            let (a, b) = (pair[0][which], pair[1][which]);
            let steps = a.distance(b).ceil().max(1.0) as usize;
            (0..steps).for_each(|k| dot(a.lerp(b, k as f64 / steps as f64), colour));
        }
    }
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, columns as u32, rows as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&pixels));
    written.map_err(|e| e.to_string())?;
    Ok(file)
}
