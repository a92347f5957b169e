//! Of steps of grey values in floats.

use super::*;

/// The step found in a frame of floats whose shadow and light hold so many values between them,
/// multiples of 1/255.
fn step_of(values: usize) -> f64 {
    let (rows, columns) = (40, 96);
    let pixels: Vec<f32> =
        (0..rows * columns).map(|i| ((7 * (i / columns) + i % columns) % values) as f32 / 255.0).collect();
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
