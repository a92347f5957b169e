//! Partially coherent light of the study's scenes.

use crate::render::optics::edge_spread::PartiallyCoherentEdge;

/// Numerical aperture, middle ratio of coherence and blur beside it (µm) of partially coherent
/// light: with a blur that hides its rings, or without.
pub(super) const fn kind_of_light(rings: bool) -> (f64, f64, f64) {
    if rings { (0.02, 0.6, 5.0) } else { (0.06, 1.0, 18.0) }
}

/// Steps of the coherence ratio: five kinds (their tables take long to compute and are cached), two
/// on either side of the middle.
const RATIO_STEP: f64 = 0.05;

/// The kind of light of the class `OtherLight`: beyond the five.
pub(super) const OTHER_KIND: f64 = 3.0;

/// Partially coherent light of a kind; those of the classes are −2 to 2.
pub(super) fn coherent(rings: bool, kind: f64) -> PartiallyCoherentEdge {
    let (na, middle, extra_sigma_um) = kind_of_light(rings);
    let coherence_ratio = middle + RATIO_STEP * kind;
    PartiallyCoherentEdge { na, coherence_ratio, extra_sigma_um, ..PartiallyCoherentEdge::default() }
}

/// The kinds from `first` to `last` in words.
fn in_words(rings: bool, first: f64, last: f64) -> String {
    let (na, middle, blur) = kind_of_light(rings);
    let ratio = |kind: f64| format!("{:.2}", middle + RATIO_STEP * kind);
    let upwards = if last > first { format!(" to {}", ratio(last)) } else { String::new() };
    format!(
        "partially coherent light of NA {na}, coherence {}{upwards}, further blur {blur} um",
        ratio(first)
    )
}

/// The light of a class in words: with rings that are visible, or hidden by a blur.
pub(super) fn light(rings: bool) -> String {
    in_words(rings, -2.0, 2.0)
}

/// The light of the class `OtherLight` in words.
pub(super) fn other_light() -> String {
    in_words(false, OTHER_KIND, OTHER_KIND)
}
