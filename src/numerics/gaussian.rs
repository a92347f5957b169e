//! A Gaussian over an image, separable: along rows, then along columns.

use rayon::prelude::*;

/// Reach of the kernel over its standard deviation: 3e-4 of its weight lies beyond.
const REACH: f64 = 3.6;

/// `rows * columns` values, row after row, under a Gaussian of standard deviations along columns
/// (rows down) and along rows, px, 0 for none; the border's values go on outside. Sums are taken in
/// the order of the kernel, so that the same values give the same bits at any number of threads.
pub(crate) fn blurred(
    values: &[f32],
    (rows, columns): (usize, usize),
    (sigma_down, sigma_along): (f64, f64),
) -> Vec<f32> {
    let (down, along) = (kernel(sigma_down), kernel(sigma_along));
    let (reach_down, reach_along) = (down.len() / 2, along.len() / 2);
    let mut by_rows = vec![0.0_f32; values.len()];
    by_rows.par_chunks_mut(columns).zip(values.par_chunks(columns)).for_each(|(out, from)| {
        let beyond = |value: f32| std::iter::repeat_n(value, reach_along);
        let (first, last) = (from[0], from[columns - 1]);
        let wide: Vec<f32> = beyond(first).chain(from.iter().copied()).chain(beyond(last)).collect();
        for (k, weight) in along.iter().enumerate() {
            add(out, *weight, &wide[k..]);
        }
    });
    let mut by_both = vec![0.0_f32; values.len()];
    by_both.par_chunks_mut(columns).enumerate().for_each(|(row, out)| {
        for (k, weight) in down.iter().enumerate() {
            let from = (row + k).saturating_sub(reach_down).min(rows - 1);
            add(out, *weight, &by_rows[from * columns..]);
        }
    });
    by_both
}

fn add(out: &mut [f32], weight: f32, from: &[f32]) {
    out.iter_mut().zip(from).for_each(|(sum, value)| *sum += weight * value);
}

/// Weights of a Gaussian, sum 1.
fn kernel(sigma: f64) -> Vec<f32> {
    let reach = (REACH * sigma).ceil() as i64;
    let weight = |k: i64| if sigma > 0.0 { (-0.5 * (k as f64 / sigma).powi(2)).exp() } else { 1.0 };
    let weights: Vec<f64> = (-reach..=reach).map(weight).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|w| (w / sum) as f32).collect()
}
