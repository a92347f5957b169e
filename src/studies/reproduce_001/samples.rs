//! The table of training samples.

use super::inputs::Inputs;
use crate::studies::reproduction::{Accept, Row};

pub(super) fn rows(inputs: &Inputs) -> Vec<Row> {
    let n = inputs.positions();
    // any two curves: the table of their sums
    let (f, g) = (|x: f64| (0.07 * x).sin(), |z: f64| 0.3 * (0.11 * z).cos() + 1e-3 * z);
    let value = |i: usize, j: usize| f(inputs.step_mm * i as f64) + g(inputs.step_mm * j as f64);
    let mixed = |i: usize, j: usize| value(i + 1, j + 1) - value(i + 1, j) - value(i, j + 1) + value(i, j);
    let largest = (0..n - 1).flat_map(|i| (0..n - 1).map(move |j| (i, j))).map(|(i, j)| mixed(i, j).abs());
    vec![
        Row::predicted(
            ("samples.count", "training samples", ""),
            Some(inputs.samples as f64),
            (n * n) as f64,
            Accept::Absolute(0.0),
            "51 × 51 positions, 2 mm apart on 100 mm",
        ),
        Row::ours(
            ("samples.values", "numbers that the table is made of", ""),
            (4 * n) as f64,
            "two curves of 51 values for X and two for Z: nothing in it depends on both positions",
        ),
        Row::predicted(
            ("samples.mixed", "largest mixed second difference of a table of sums", ""),
            Some(0.0),
            largest.fold(0.0, f64::max),
            Accept::Absolute(1e-12),
            "δ2X(xi) + δ1X(zj): a net of two inputs learns a sum of two curves",
        ),
    ]
}
