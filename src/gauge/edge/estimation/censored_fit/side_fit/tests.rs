//! Of a side whose light is clipped.

use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;

use super::*;
use crate::gauge::edge::image::scan_windows::Side;
use crate::gauge::edge::image::window_layout::half;
use crate::gauge::edge::model::gaussian::EdgeSample;

const COLUMNS: usize = 256;
const WIDTH: usize = 24;
/// Levels and the end of the grey scale, counts.
const DARK: f64 = 20.0;
const LIGHT: f64 = 260.0;
const END: f64 = 200.0;

/// Windows of an edge of `sigma` px that drifts over a pixel, its light clipped, noise of 2 counts.
fn windows(sigma: f64) -> Windows {
    let mut rng = Pcg64::seed_from_u64(5);
    let noise = Normal::new(0.0, 2.0).unwrap();
    let mut windows = Windows::new(Side::Bottom);
    (windows.width, windows.flat) = (WIDTH, 4);
    for column in 0..COLUMNS {
        let x = column as f64 / COLUMNS as f64 - 0.5;
        let mut samples = [EdgeSample::default(); WIDTH];
        EdgeSpreadFunction::Gaussian.samples(-(half(WIDTH) as f64), x, sigma, &mut samples);
        windows.pixels.extend(samples.iter().map(|sample| {
            let value = DARK + (LIGHT - DARK) * sample.value + noise.sample(&mut rng);
            value.round().clamp(0.0, END) as f32
        }));
        windows.centre.push(Ok(100));
        windows.start.push(x as f32);
        windows.dark.push(DARK as f32);
        windows.light.push(END as f32);
    }
    windows
}

/// Edges and the fit of a side of 1 px blur, which is given or to be found.
fn fitted(windows: &Windows, sigma_is_given: bool) -> (Vec<Edge>, ClippedSide) {
    let curve = |level: f64| LevelCurve {
        level: vec![level as f32; COLUMNS],
        uncertainty: vec![0.1; COLUMNS],
        length: COLUMNS as f32,
        mean: level,
    };
    let (dark, light) = (curve(DARK), curve(END));
    let start = ClippedStart {
        shape: &EdgeSpreadFunction::Gaussian,
        levels: [&dark, &light],
        sigma: 1.0,
        sigma_is_given,
        variance: [4.0, 4.0],
        floor: 0.1,
        ends: Ends { low: f64::NEG_INFINITY, high: END, step: 1.0 },
    };
    let mut line = Vec::new();
    let side = fit_side(windows, &[0.0; COLUMNS], &start, &mut line).unwrap();
    (line, side)
}

/// Two hot pixels in a column's shadow are left out; four are contamination.
#[test]
fn a_column_with_more_than_two_stray_pixels_is_refused() {
    let mut windows = windows(1.0);
    for (column, hot) in [(100, 2), (150, 4)] {
        windows.pixels[column * WIDTH..column * WIDTH + hot].fill(END as f32);
    }
    let (line, _) = fitted(&windows, false);
    let off = |column: usize| line[column].row_px - 100.0 - (column as f64 / COLUMNS as f64 - 0.5);
    assert!(line[100].is_usable() && off(100).abs() < 0.1, "{:?}", line[100]);
    assert_eq!(line[150].reason(), Some(Reason::Residual));
}

/// A blur that is given is kept where the flank shows 5 % more; where it is not given, it is found.
#[test]
fn a_given_blur_is_kept_whatever_the_flank_shows() {
    let windows = windows(1.05);
    let (_, found) = fitted(&windows, false);
    assert!((found.sigma - 1.05).abs() < 0.02, "{}", found.sigma);
    let (_, given) = fitted(&windows, true);
    assert!((given.sigma - 1.0).abs() < 3e-3, "{}", given.sigma);
}
