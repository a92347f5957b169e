//! Reasons for which no flank wear is measured.

use thiserror::Error;

/// Why an image gives no flank wear.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub(crate) enum FlankError {
    /// A pixel is not a number.
    #[error("pixel at row {row}, column {column} is not finite")]
    NotFinite {
        /// Its row.
        row: usize,
        /// Its column.
        column: usize,
    },
    /// A frame in which no strip fits.
    #[error(
        "an image of {rows} x {columns} px is too small for a flank: at least {least} px a side are needed"
    )]
    TooSmall {
        /// Rows.
        rows: usize,
        /// Columns.
        columns: usize,
        /// Least side, px.
        least: usize,
    },
    /// Nothing in focus, or nothing with a straight border.
    #[error(
        "no flank: {why}; put the cutting edge and its flank into focus and light the flank from the front"
    )]
    NoFlank {
        /// What was seen instead.
        why: String,
    },
    /// The land reaches the end of what the image shows.
    #[error(
        "the land leaves the field at row {row:.0}, column {column:.0}: move the tool so that the whole worn length and \
         the flank below it are inside"
    )]
    LeavesField {
        /// Where.
        row: f64,
        /// Where.
        column: f64,
    },
    /// Two borders of what is in focus, either of which could be the cutting edge.
    #[error(
        "two borders could be the cutting edge, about row {row:.0}, column {column:.0} and about row {other_row:.0}, \
         column {other_column:.0}: state at which side of it the flank lies (--flank-side), or move the tool so that \
         one border alone is in the image"
    )]
    TwoEdges {
        /// Middle of the likelier one.
        row: f64,
        /// Middle of the likelier one.
        column: f64,
        /// Middle of the other.
        other_row: f64,
        /// Middle of the other.
        other_column: f64,
    },
    /// Hardly a border at the stated side, while another stands out.
    #[error(
        "no edge whose flank lies at the stated side ({side}) stands out as the one about row {row:.0}, column {column:.0} \
         does: state the side of that one (--flank-side), or leave it out"
    )]
    OtherSide {
        /// The side, as it is stated.
        side: &'static str,
        /// Middle of the border that stands out.
        row: f64,
        /// Middle of the border that stands out.
        column: f64,
    },
    /// Saturated light hides the land's border.
    #[error(
        "glare over the land: {share:.0} % of its border is saturated, about row {row:.0}, column {column:.0}; at most \
         {most:.0} % can be bridged: turn the light, or expose less"
    )]
    Glare {
        /// Share of the border's length, %.
        share: f64,
        /// Largest share, %.
        most: f64,
        /// Middle of the largest saturated stretch.
        row: f64,
        /// Middle of the largest saturated stretch.
        column: f64,
    },
    /// A model that cannot be read.
    #[error("the model is refused: {0}")]
    Model(String),
    /// No straight reference on both sides of what is worn, or a baseline of another edge.
    #[error("the reference line is refused: {0}")]
    Reference(String),
}
