//! What a flat field may be, and when it is applied.

use shadowgauge::frame::{Buffer, Frame, FrameMeta, PixelFormat};
use shadowgauge::gauge::sensor::flat_field::{FlatField, FlatFieldError};

const SIZE: (usize, usize) = (48, 64);
const BLACK: f64 = 64.0;
const SIGNAL: f64 = 2000.0;

fn frame(mean: impl Fn(usize, usize) -> f64) -> Frame {
    let pixels = (0..SIZE.0 * SIZE.1).map(|i| mean(i / SIZE.1, i % SIZE.1).round() as u16).collect();
    Frame::new(Buffer::U16(pixels), PixelFormat::Mono12, SIZE.0, SIZE.1, FrameMeta::default()).unwrap()
}

/// Light that falls along a row from 1 to 1 less `by`.
fn falling(by: f64, column: usize) -> f64 {
    1.0 - by * column as f64 / (SIZE.1 - 1) as f64
}

/// From frames without noise of a sensor with so many hot pixels, in light that falls by a share.
fn made(hot: usize, by: f64) -> Result<FlatField, FlatFieldError> {
    let is_hot = |r: usize, c: usize| (r * SIZE.1 + c) % 31 == 7 && (r * SIZE.1 + c) / 31 < hot;
    let dark = |r: usize, c: usize| BLACK + if is_hot(r, c) { 500.0 } else { 0.0 };
    let flat = |r: usize, c: usize| dark(r, c) + SIGNAL * falling(by, c);
    let (dark, flat) = ([frame(dark), frame(dark)], [frame(flat), frame(flat)]);
    FlatField::new(&dark.each_ref().map(Frame::view), &flat.each_ref().map(Frame::view))
}

/// Light of 0.4 of the brightest is a vignette; of 0.2 something stands in the light.
#[test]
fn light_that_falls_to_a_fifth_is_no_flat_field() {
    let field = made(0, 0.6).unwrap();
    assert!((field.fall_off - 0.6).abs() < 1e-3 && field.impossible_light().is_none(), "{field:?}");
    match made(0, 0.8) {
        Err(FlatFieldError::NotFlat { darkest }) => assert!((darkest - 0.2).abs() < 1e-3, "{darkest}"),
        other => panic!("{other:?}"),
    }
}

/// Of 3072 pixels 23 are hot, 0.75 %: a bad sensor. With 46, 1.5 %, it is no dark field.
#[test]
fn a_sensor_with_too_many_defects_is_a_wrong_picture() {
    assert_eq!(made(23, 0.0).unwrap().defects.len(), 23);
    assert_eq!(made(46, 0.0), Err(FlatFieldError::Defects { found: 46, pixels: 3072 }));
}

/// A fall-off of 0.7 % leaves a frame as it is; one of 1.4 % is taken off to a count.
#[test]
fn light_is_corrected_from_a_hundredth_on() {
    let corrected = |by: f64| {
        let lit = || frame(|_, c| BLACK + SIGNAL * falling(by, c));
        (lit(), made(0, by).unwrap().corrected(lit()))
    };
    let row = |frame: &Frame| -> Vec<f32> {
        let view = frame.view();
        (0..SIZE.1).filter_map(|column| view.get(20, column)).collect()
    };
    let (before, after) = corrected(0.007);
    assert_eq!(row(&before), row(&after));
    let (_, after) = corrected(0.014);
    let dim = (BLACK + SIGNAL * 0.986) as f32;
    assert!(row(&after).iter().all(|value| (value - dim).abs() <= 1.5), "{:?}", row(&after));
}

/// The surface of a file with seven digits reaches 1 + 5e-7 at its brightest by rounding; one of 1
/// + 1.4e-6 was not written so.
#[test]
fn a_surface_may_exceed_one_by_the_rounding_of_its_digits() {
    let field = |brightest: f64| FlatField {
        light: [brightest, 0.0, 0.0, 0.0, 0.0, 0.0],
        fall_off: 0.0,
        ..made(0, 0.0).unwrap()
    };
    assert_eq!(field(1.0 + 7e-7).impossible_light(), None);
    assert_eq!(field(1.0 + 1.4e-6).impossible_light().unwrap().0, "bench.flat_field.light");
}
