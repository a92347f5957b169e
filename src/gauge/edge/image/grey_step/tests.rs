//! Of steps of grey values in floats.

use super::*;

/// The step found in a frame of floats whose shadow and light hold so many values between them,
/// multiples of 1/255.
fn step_of(values: usize) -> f64 {
    step_with(values, 0.0)
}

/// The same where the largest value stands by so many steps beside its multiple.
fn step_with(values: usize, beside: f32) -> f64 {
    let (rows, columns) = (40, 96);
    let value = |k: usize| (k as f32 + if k + 1 == values { beside } else { 0.0 }) / 255.0;
    let pixels: Vec<f32> =
        (0..rows * columns).map(|i| value((7 * (i / columns) + i % columns) % values)).collect();
    let plane = Plane { pixels: &pixels, rows, columns, row_stride: columns, column_stride: 1, sign: 1.0 };
    let edge = |row: i32| vec![CoarseEdge::Ok(row); columns];
    grey_step(&plane, [&edge(14), &edge(26)], false)
}

/// Twenty different floats whose gaps are multiples of one are eight bits; twelve, of a frame of
/// little contrast, may be so by chance.
#[test]
fn floats_show_a_step_from_sixteen_values_on() {
    assert!((step_of(20) - 1.0 / 255.0).abs() < 1e-7, "{}", step_of(20));
    assert_eq!(step_of(12), 0.0);
}

/// Conversions to f32 and back leave a float far nearer to its multiple than a hundredth and a half
/// of the step; three hundredths are another value.
#[test]
fn a_float_beside_a_multiple_is_one() {
    assert!(step_with(20, 0.015) > 0.0);
    assert_eq!(step_with(20, 0.03), 0.0);
}
