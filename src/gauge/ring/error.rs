//! Why no ring is measured.

use thiserror::Error;

/// Why a frame gives no ring.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RingError {
    /// A setting out of range.
    #[error("ring.{key} = {value}: must be {right}")]
    Setting {
        /// The key.
        key: &'static str,
        /// What stands there.
        value: f64,
        /// What would be right.
        right: &'static str,
    },
    /// A pixel is not a number.
    #[error("pixel at row {row}, column {column} is not finite")]
    NotFinite {
        /// Its row.
        row: usize,
        /// Its column.
        column: usize,
    },
    /// No light and shadow in the frame.
    #[error("light and shadow differ by {contrast} counts against a noise of {noise}: no part to be seen")]
    LowContrast {
        /// Difference of the levels, counts.
        contrast: f64,
        /// Noise, counts.
        noise: f64,
    },
    /// No part lies wholly in the frame.
    #[error("no part of at least {least} px across lies wholly in the frame ({found} shadows seen)")]
    NoPart {
        /// Least diameter, px.
        least: f64,
        /// Shadows seen, of any size.
        found: usize,
    },
    /// The part is no ring or disc.
    #[error(
        "the shadow is not round: its outline stands between {inner:.1} and {outer:.1} px from its centre"
    )]
    NotRound {
        /// Tenth percentile of the outline's radii, px.
        inner: f64,
        /// Ninetieth percentile, px.
        outer: f64,
    },
    /// An edge could not be fitted.
    #[error("the {edge} edge cannot be fitted: {why}")]
    Edge {
        /// Outer or inner.
        edge: &'static str,
        /// What went wrong.
        why: String,
    },
}
