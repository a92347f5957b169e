//! Statistics that are insensitive to a minority of outliers.

use std::cmp::Ordering;

/// Standard deviation of a normal distribution over the median of its absolute deviations,
/// 1/Φ⁻¹(3/4).
pub(crate) const MEDIAN_TO_SD: f64 = 1.4826;

/// The same to the resolution of a double, for the weights of stations' readings.
pub(crate) const MAD_TO_SIGMA: f64 = 1.482_602_218_505_602;

/// Median, the upper one of the two middle values of an even number; reorders the values.
pub(crate) fn upper_median<T: Copy>(values: &mut [T], order: impl FnMut(&T, &T) -> Ordering) -> Option<T> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, order).1)
}

/// The same for a list; 0 for an empty one.
pub(crate) fn median_of(mut values: Vec<f64>) -> f64 {
    upper_median(&mut values, f64::total_cmp).unwrap_or(0.0)
}

/// Median, the mean of the two middle values of an even number; sorts the values.
pub(crate) fn central_median(values: &mut [f64]) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    Some(0.5 * (values.get(n / 2)? + values.get(n.saturating_sub(1) / 2)?))
}
