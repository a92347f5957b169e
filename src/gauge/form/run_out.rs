//! Radial run-out (ISO 1101) from the heights of one edge; the datum axis is the spindle's.
//!
//! What an indicator at the top edge would read over a revolution: it contains eccentricity, form
//! and the spindle's own motion. A silhouette's indicator has a flat, infinitely wide anvil, so
//! that hollows narrower than the tangent are not seen.

/// Circular radial run-out: full indicator movement of one section over a revolution, in the
/// heights' unit. `None` without finite heights.
pub(crate) fn circular_run_out(heights: &[f64]) -> Option<f64> {
    span(heights.iter().copied())
}

/// Total radial run-out: full movement over all sections, each height measured from the one datum
/// axis. `None` without finite heights.
pub(crate) fn total_run_out<H: AsRef<[f64]>>(sections: &[H]) -> Option<f64> {
    span(sections.iter().flat_map(|s| s.as_ref().iter().copied()))
}

fn span(heights: impl Iterator<Item = f64>) -> Option<f64> {
    let (low, high) = heights
        .filter(|h| h.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    (high >= low).then_some(high - low)
}
