//! Noses of rendered inserts: the renderer's golden values, and the measurement against the truth.

mod drawn;
mod found;
mod paper;
mod refused;

use shadowgauge::gauge::nose::{NoseImageError, NoseMeasurement, NoseSettings, measure_nose};
use shadowgauge::render::insert::{InsertSettings, Truth, render_insert};

/// A small field about a corner of 60° whose nose of 0.2 mm points down and to the left, from a
/// pose.
pub(super) fn insert(pose: usize) -> InsertSettings {
    let mut s = InsertSettings::default();
    (s.camera.columns, s.camera.rows) = (520, 420);
    s.nose.radius_mm = 0.2;
    s.nose.direction_deg = (237.0 + 67.3 * pose as f64).rem_euclid(360.0);
    let towards = s.nose.direction_deg.to_radians();
    let part = 0.618_034 * pose as f64;
    s.nose.centre_px =
        [260.0 + 60.0 * towards.cos() + part.fract(), 210.0 - 60.0 * towards.sin() + part.fract()];
    s
}

/// Renders with noise and measures; `nominal` gives the radius as ground.
pub(super) fn measured(
    settings: &InsertSettings,
    seed: u64,
    nominal: bool,
) -> (Result<NoseMeasurement, NoseImageError>, Truth) {
    let (frame, truth) = render_insert(settings, (seed, 0), true).unwrap();
    let known = NoseSettings {
        nominal_radius_px: nominal.then_some(truth.nominal_radius_px),
        um_per_px: settings.camera.um_per_px,
        expected: None,
    };
    (measure_nose(&frame.view(), &known), truth)
}

/// A value of a table of (degrees, value) in even steps, straight between them.
pub(super) fn at(table: &[[f64; 2]], deg: f64) -> f64 {
    let (from, last) = (table[0][0], table.len() - 1);
    let place = (deg - from).rem_euclid(360.0) / (table[last][0] - from) * last as f64;
    let k = (place as usize).min(last - 1);
    table[k][1] + (place - k as f64) * (table[k + 1][1] - table[k][1])
}
