//! Reasons for which no ring is measured.

use thiserror::Error;

use crate::setting::SettingError;

/// Why a frame gives no ring.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RingError {
    /// A setting out of range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// A pixel is not a number.
    #[error("pixel at row {row}, column {column} is not finite")]
    NotFinite {
        /// Its row.
        row: usize,
        /// Its column.
        column: usize,
    },
    /// No light and shadow in the frame.
    #[error(
        "the grey values do not fall into light and shadow: their two halves differ by {contrast:.1} counts and scatter by {noise:.1}, at least {least} times that and 4 counts are needed; no shadow stands between light either: put a part into the field, light it from behind, or expose more"
    )]
    LowContrast {
        /// Difference of the levels, counts.
        contrast: f64,
        /// Scatter of both, counts.
        noise: f64,
        /// Least contrast over scatter.
        least: f64,
    },
    /// No part lies wholly in the frame.
    #[error("no part of at least {least} px across lies wholly in the frame: {}", seen(*found, *largest, *at_border))]
    NoPart {
        /// Least diameter, px.
        least: f64,
        /// Shadows seen, of any size.
        found: usize,
        /// Diameter of a circle of the largest one's area, px.
        largest: f64,
        /// Whether that one touches the frame's border.
        at_border: bool,
    },
    /// The part is no ring or disc.
    #[error(
        "the shadow is not round: its outline stands between {inner:.1} and {outer:.1} px from its centre, where a ring's or disc's may differ by {most:.1} px; a shaft seen from the side needs --shape shaft"
    )]
    NotRound {
        /// Tenth percentile of the outline's radii, px.
        inner: f64,
        /// Ninetieth percentile, px.
        outer: f64,
        /// Most difference of a round part's, px.
        most: f64,
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

/// What was seen instead of a part, and what would help.
fn seen(found: usize, largest: f64, at_border: bool) -> String {
    match (found, at_border) {
        (0, _) => "no shadow was seen; a lit part before a dark ground needs --bright-on-dark".to_owned(),
        (_, true) => format!(
            "of {found} shadows the largest, as large as a disc of {largest:.1} px, touches the border of the frame: move the part inside; a lit part before a dark ground needs --bright-on-dark"
        ),
        (_, false) => format!(
            "of {found} shadows the largest is as large as a disc of {largest:.1} px; --min-diameter-px sets the least size, 16 px at least"
        ),
    }
}
