//! The measured nose over its image: edges, nominal circle, contour.

use glam::DVec2;

use super::canvas::Canvas;
use crate::frame::FrameView;
use crate::gauge::nose::NoseMeasurement;

/// Colours of what is drawn: edges and nominal circle in blue, the contour as measured in orange
/// (M. Okabe, K. Ito, colours for all kinds of sight).
const NOMINAL: [u8; 3] = [0, 114, 178];
const MEASURED: [u8; 3] = [230, 159, 0];

/// An RGB PNG.
///
/// # Errors
/// Where the encoder refuses it, as text.
pub(crate) fn overlay(view: &FrameView<'_>, m: &NoseMeasurement) -> Result<Vec<u8>, String> {
    let (rows, columns) = (view.rows(), view.columns());
    let [low, high] = m.levels;
    let grey = |row: usize, column: usize| {
        let value = f64::from(view.get(row, column).unwrap_or(0.0));
        (40.0 + 200.0 * (value - low) / (high - low)).clamp(0.0, 255.0) as u8
    };
    let mut canvas = Canvas::new((rows, columns), grey);
    // y of a nose points up
    let mut dot = |p: DVec2, colour: [u8; 3]| canvas.dot(DVec2::new(p.x, -p.y), colour);
    let around = |deg: f64, radius: f64| m.centre + DVec2::from_angle(deg.to_radians()) * radius;
    let sweep = (m.normals_deg[1] - m.normals_deg[0]).rem_euclid(360.0);
    let steps = (4.0 * m.nominal_radius_px) as usize;
    for k in 0..=steps {
        dot(around(m.normals_deg[0] + sweep * k as f64 / steps as f64, m.nominal_radius_px), NOMINAL);
    }
    for (deg, side) in m.normals_deg.into_iter().zip([-1.0, 1.0]) {
        let (from, along) =
            (around(deg, m.nominal_radius_px), DVec2::from_angle(deg.to_radians()).perp() * side);
        (0..2 * (rows + columns)).for_each(|k| dot(from + along * (0.5 * k as f64), NOMINAL));
    }
    for pair in m.sectors.windows(2) {
        for k in 0..8 {
            let t = f64::from(k) / 8.0;
            let turn = (pair[1].direction_deg - pair[0].direction_deg).rem_euclid(360.0);
            let radius = pair[0].radius_px + t * (pair[1].radius_px - pair[0].radius_px);
            dot(around(pair[0].direction_deg + t * turn, radius), MEASURED);
        }
    }
    canvas.png()
}
