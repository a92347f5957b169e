//! Reasons of gaps in words that need no list beside them.

use crate::profile::Reason;

/// Why there is no value, or why one is impaired.
pub(super) fn reason_words(reason: Reason) -> &'static str {
    match reason {
        Reason::NoEdge => "no transition between light and shadow",
        Reason::OneEdge => "only one edge of the shadow in the field",
        Reason::Steep => "edge too steep: a flank, a shoulder",
        Reason::LowContrast => "contrast too low against the noise",
        Reason::Clipped => "edge clipped at the end of the grey scale (measured, with a larger uncertainty)",
        Reason::Saturated => "bright field saturated",
        Reason::Residual => "grey values unlike an edge",
        Reason::Outlier => "edge away from its neighbours",
        Reason::Border => "edge too close to the border of the field",
        Reason::Contaminated => "contamination, a chip or a droplet on the edge",
        Reason::Repeated => "rows or columns of the frame repeat each other",
        Reason::SeveralShadows => "two shadows, and which is meant was not stated",
        Reason::Unreadable => "frame not readable",
        Reason::Blurred => "blurred otherwise than the masters",
        Reason::Implausible => "contradicts earlier turns, or is no number",
        Reason::TooFewColumns => "too few good columns",
        Reason::NotScanned => "not in any frame",
    }
}
