//! Statistics that a minority of wild values does not move.

/// Standard deviation of a normal distribution over the median of its absolute deviations, 1/Φ⁻¹(3/4).
pub(crate) const MEDIAN_TO_SD: f64 = 1.4826;

/// Median of some values, the upper one of an even number; 0 of none.
pub(crate) fn median_of(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
