//! Neighbours in an ascending list, and the line through them.

/// The last item before a place in an ascending list, and the first that is not before it.
pub(crate) fn neighbours<T>(items: &[T], before: impl FnMut(&T) -> bool) -> (Option<&T>, Option<&T>) {
    let after = items.partition_point(before);
    (after.checked_sub(1).and_then(|i| items.get(i)), items.get(after))
}

/// Ordinate at `x`, linear between two neighbours, that of the only one beyond the ends; `None` of
/// an empty list.
pub(crate) fn linear_between<T>(
    pair: (Option<&T>, Option<&T>),
    x: f64,
    point: impl Fn(&T) -> (f64, f64),
) -> Option<f64> {
    match (pair.0.map(&point), pair.1.map(&point)) {
        (Some((x0, y0)), Some((x1, y1))) => Some(y0 + (y1 - y0) * (x - x0) / (x1 - x0)),
        (Some((_, only)), None) | (None, Some((_, only))) => Some(only),
        (None, None) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_and_beyond_the_points_and_without_any() {
        let points = [(1.0, 10.0), (3.0, 20.0)];
        let at = |x: f64| linear_between(neighbours(&points, |p| p.0 < x), x, |p| *p);
        assert_eq!([0.0, 1.0, 2.0, 3.0, 4.0].map(at), [10.0, 10.0, 15.0, 20.0, 20.0].map(Some));
        assert_eq!(linear_between(neighbours(&points[..0], |p| p.0 < 1.0), 1.0, |p| *p), None);
    }
}
