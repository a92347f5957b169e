//! What form analysis refuses.

use thiserror::Error;

/// Why a form feature cannot be computed.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum FormError {
    /// Too few points for the feature.
    #[error("{found} points do not define a {feature}; at least {needed} are needed")]
    TooFew {
        /// The feature asked for.
        feature: &'static str,
        /// Points given.
        found: usize,
        /// Points needed.
        needed: usize,
    },
    /// A coordinate is not a number.
    #[error("point {index} is not finite")]
    NotFinite {
        /// Its index.
        index: usize,
    },
    /// The points do not determine the feature, for instance all on one line.
    #[error("the points do not determine a {feature}: they coincide or lie on a lower-dimensional shape")]
    Degenerate {
        /// The feature asked for.
        feature: &'static str,
    },
    /// The iteration did not settle.
    #[error("the {feature} did not converge; the points cover too short an arc or hold gross outliers")]
    NotConverged {
        /// The feature asked for.
        feature: &'static str,
    },
    /// The two edges of a revolution differ in number.
    #[error("{top} top edges but {bottom} bottom edges; a turn needs one of each at every angle")]
    Unpaired {
        /// Top edges.
        top: usize,
        /// Bottom edges.
        bottom: usize,
    },
    /// Angles that do not divide one revolution evenly.
    #[error(
        "reading {index} stands at {angle_deg} deg but an even division of one turn has {expected_deg} deg there; \
         resample to even angles first"
    )]
    UnevenAngles {
        /// The first reading off its place.
        index: usize,
        /// Where it stands.
        angle_deg: f64,
        /// Where it should.
        expected_deg: f64,
    },
    /// An argument is out of range.
    #[error("{name} = {value}: must be {right}")]
    Argument {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What would be right.
        right: &'static str,
    },
    /// A support function that belongs to no convex body at this filter.
    #[error(
        "the silhouette is not convex at {angle_deg} deg (radius of curvature {curvature_radius}): noise dominates \
         its second derivative; filter to fewer undulations per revolution"
    )]
    NotConvex {
        /// Where.
        angle_deg: f64,
        /// h + h'' there, in the input's unit.
        curvature_radius: f64,
    },
}
