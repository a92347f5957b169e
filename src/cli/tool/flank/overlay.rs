//! Reference line and border of the land over the image.

use glam::DVec2;

use crate::cli::tool::canvas::Canvas;
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
    let grey =
        |row: usize, column: usize| (255.0 * value(row * columns + column) / most).clamp(0.0, 255.0) as u8;
    let mut canvas = Canvas::new((rows, columns), grey);
    for pair in places.windows(2) {
        for (which, colour) in [(0, REFERENCE), (1, LAND)] {
            let (a, b) = (pair[0][which], pair[1][which]);
            let steps = a.distance(b).ceil().max(1.0) as usize;
            (0..steps).for_each(|k| canvas.dot(a.lerp(b, k as f64 / steps as f64), colour));
        }
    }
    canvas.png()
}
