//! Of the ends of the grey scale.

use super::*;
use crate::gauge::edge::image::scan_windows::Side;

#[test]
fn a_hot_pixel_is_no_scatter_of_a_quiet_level() {
    let mut squares = vec![0.0_f32; 100];
    squares[..20].fill(1.0);
    let quiet = robust_mean(&mut squares.clone(), 1.0).unwrap();
    assert!((quiet - 0.2).abs() < 1e-6, "{quiet}");
    squares[99] = 239.0 * 239.0;
    let hot = robust_mean(&mut squares, 1.0).unwrap();
    assert!((hot - 20.0 / 99.0).abs() < 1e-6, "{hot}");
    assert_eq!(robust_mean(&mut [0.0; 50], 1.0), Some(0.0));
    // Nothing but hot pixels differs: without a step they are the scatter, with one they are
    // not.
    let mut lone = vec![0.0_f32; 99];
    lone.push(240.0 * 240.0);
    assert_eq!(robust_mean(&mut lone, 1.0), Some(0.0));
}

/// A clipped level of a quiet camera: of 4000 flat pixels 2560 stand at the end, the others a count
/// below, and so many are hot, a count beyond. A bell of 0.5 counts with these shares has 201
/// pixels a count beyond its last grey value: hot pixels may be a fifth of them.
fn quiet_end(hot: usize) -> Option<(f32, f64)> {
    let mut pool = vec![200.0_f32; 4000];
    pool[..1440 - hot].fill(199.0);
    pool[4000 - hot..].fill(201.0);
    judge(&mut pool, 1.0, 150.0, |_, _, _| 0.5)
}

#[test]
fn few_hot_pixels_stand_beyond_an_end_and_the_other_half_of_a_bell_does_not() {
    assert_eq!(quiet_end(30), Some((200.0, 1.0)));
    assert_eq!(quiet_end(60), None);
}

/// Floats without a step, of which two in five stand at the largest value: with noise of 1.4e-3 of
/// the contrast they are clipped there, with half of that they are a rendering's flat light.
#[test]
fn floats_without_noise_have_no_end() {
    let end = |noise: f64| {
        let below = |k: usize| 1.0 - (noise as f32) * (k % 100) as f32 / 50.0;
        let mut pool: Vec<f32> = (0..4000).map(|k| if k % 5 < 2 { 1.0 } else { below(k) }).collect();
        judge(&mut pool, 0.0, 1.0, |_, _, _| noise).map(|(end, _)| end)
    };
    assert_eq!(end(1.4e-3), Some(1.0));
    assert_eq!(end(0.7e-3), None);
}

/// Every frame pays for the glance, and one that looks clipped for the search: both are bounded
/// however wide the frame is, to 64 columns and to 4096 pixels, of which the sixtieth part at one
/// value (61 of them) is known to an eighth.
#[test]
fn few_of_the_pixels_of_a_wide_frame_are_looked_at() {
    let (columns, flat, width) = (4096, 4, 17);
    let mut windows = Windows::new(Side::Top);
    (windows.width, windows.flat) = (width, flat);
    windows.pixels = vec![100.0; columns * width];
    windows.centre = vec![Ok(50); columns];
    let (mut pool, mut squares) = (Vec::new(), Vec::new());
    may_end(&windows, Level::Light, &mut pool);
    assert_eq!(pool.len(), 64 * flat);
    let elsewhere = Elsewhere { noise: [1.0; 2], levels: [10.0, 100.0], step: 1.0, turned: false };
    find_end(&windows, Level::Light, &elsewhere, (&mut pool, &mut squares));
    assert_eq!(pool.len(), 4096);
}
