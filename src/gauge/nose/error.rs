//! Reasons for which no nose is measured.

use thiserror::Error;

/// Why a frame gives no nose.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub(crate) enum NoseImageError {
    /// A pixel is not a number.
    #[error("pixel at row {row}, column {column} is not finite")]
    NotFinite {
        /// Its row.
        row: usize,
        /// Its column.
        column: usize,
    },
    /// No light and shadow in the frame, or no shadow that is large enough.
    #[error("no insert: {why}; put the insert into the field before the backlight, or expose more")]
    NoInsert {
        /// What was seen instead.
        why: String,
    },
    /// A bright insert on a dark ground.
    #[error(
        "light and shadow are swapped: the insert about row {row:.0}, column {column:.0} is bright and its ground dark; put \
         the light behind the insert, or give the image as the camera took it, not inverted"
    )]
    Swapped {
        /// Middle of its nose.
        row: f64,
        /// Middle of its nose.
        column: f64,
    },
    /// Two parts.
    #[error(
        "two inserts: shadows of {first} and {second} px, about row {row}, column {column} the second; leave one in \
         the field"
    )]
    TwoInserts {
        /// Pixels of the larger one.
        first: usize,
        /// Pixels of the second one.
        second: usize,
        /// Middle of the second one.
        row: usize,
        /// Middle of the second one.
        column: usize,
    },
    /// The nose is not in the frame.
    #[error(
        "the nose lies outside of the field: the edges meet at row {row:.0}, column {column:.0} of {rows} x {columns} and \
         the border cuts the nose; move the tool so that the nose and {least:.0} px of both edges are inside"
    )]
    OutsideField {
        /// Where the edges meet.
        row: f64,
        /// Where the edges meet.
        column: f64,
        /// Rows of the frame.
        rows: usize,
        /// Columns of the frame.
        columns: usize,
        /// Least length of an edge, px.
        least: f64,
    },
    /// No two straight edges.
    #[error(
        "no nose: {found} straight edges of {least:.0} px or more stand on the silhouette, and no two of them enclose \
         an angle of {low:.0} to {high:.0} degrees; a nose shows both cutting edges beside it"
    )]
    NoNose {
        /// Straight edges found.
        found: usize,
        /// Least length, px.
        least: f64,
        /// Least angle, degrees.
        low: f64,
        /// Largest angle, degrees.
        high: f64,
    },
    /// Blur beyond the model's range.
    #[error(
        "focus lost: the edges are blurred by {sigma_px:.2} px (standard deviation), at most {most_px} px can be \
         measured; move the tool into the plane of focus"
    )]
    Focus {
        /// Blur, px.
        sigma_px: f64,
        /// Largest blur, px.
        most_px: f64,
    },
    /// The pooled fit fails.
    #[error("the contour cannot be fitted: {0}")]
    Fit(String),
    /// Many sectors without an edge.
    #[error(
        "no single edge fits in {refused} of {sectors} sectors of the nose, the first at {direction_deg:.0} degrees \
         (row {row:.0}, column {column:.0}): a double contour, dirt or another part there; clean the insert, or look for \
         reflections"
    )]
    Sectors {
        /// Sectors without an edge.
        refused: usize,
        /// All.
        sectors: usize,
        /// Direction of the first one.
        direction_deg: f64,
        /// Its place.
        row: f64,
        /// Its place.
        column: f64,
    },
    /// An edge whose calipers show no edge as the model has it.
    #[error(
        "no blurred edge fits in {refused} of {calipers} calipers of the cutting edge about row {row:.0}, column {column:.0}: \
         the light there does not pass from shadow to light as a lens blurs it; give the image as the camera took it, not made \
         smaller, sharpened or compressed, and keep reflections off the edge"
    )]
    NoEdgeModel {
        /// Middle of the edge.
        row: f64,
        /// Middle of the edge.
        column: f64,
        /// Calipers that no edge fits.
        refused: usize,
        /// All.
        calipers: usize,
    },
    /// An edge that is no line.
    #[error(
        "the cutting edge about row {row:.0}, column {column:.0} is not straight: of {fitted} calipers in which an edge fits \
         {on_line} lie on a line; clean it, or show more of the edge beyond the worn length"
    )]
    NotStraight {
        /// Middle of the edge.
        row: f64,
        /// Middle of the edge.
        column: f64,
        /// Calipers on the line.
        on_line: usize,
        /// Calipers in which an edge fits.
        fitted: usize,
    },
    /// An angle that is not the tool's.
    #[error(
        "the edges enclose {found_deg:.3} degrees, the tool's epsilon_r_deg is {tool_deg}: at most {most_deg} degrees apart \
         they are of one insert; give the file of this tool by --tool"
    )]
    Angle {
        /// As measured, degrees.
        found_deg: f64,
        /// The tool's, degrees.
        tool_deg: f64,
        /// Most that they may differ, degrees.
        most_deg: f64,
    },
    /// A nose that is not as large as it should be.
    #[error(
        "the nose has a radius of about {found_px:.0} px ({:.3} mm at {um_per_px} um per px), and {nominal_px:.1} px ({:.3} \
         mm) are nominal: give the file of this tool by --tool, the baseline of this insert, or the scale of this picture",
        1e-3 * found_px * um_per_px,
        1e-3 * nominal_px * um_per_px
    )]
    Radius {
        /// Of the coarse contour, px.
        found_px: f64,
        /// The tool's or the baseline's, px.
        nominal_px: f64,
        /// Scale, um per px.
        um_per_px: f64,
    },
    /// A picture that lies otherwise than the tool.
    #[error(
        "the picture is {how}: the nose points to {found_deg:.1} degrees, by the {by} to {expected_deg:.1} (0 to the right, \
         counter-clockwise); {remedy}"
    )]
    Orientation {
        /// Rotated by how much, or mirrored.
        how: String,
        /// As measured, degrees.
        found_deg: f64,
        /// What states the direction.
        by: &'static str,
        /// Expected, degrees.
        expected_deg: f64,
        /// What would be right.
        remedy: &'static str,
    },
    /// A baseline of another insert.
    #[error("the baseline is of another insert: {why}; measure the same insert new, in the same holder")]
    Baseline {
        /// What differs.
        why: String,
    },
}
