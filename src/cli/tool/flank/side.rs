//! At which side of its edge a flank lies, as stated on the command line.

use crate::gauge::flank::FlankSide;

/// A side in the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(in crate::cli) enum Side {
    /// Not stated: refused where two borders could be the edge.
    Any,
    /// Below the edge.
    Below,
    /// To its right.
    Right,
    /// Above it.
    Above,
    /// To its left.
    Left,
}

impl From<Side> for FlankSide {
    fn from(side: Side) -> Self {
        match side {
            Side::Any => Self::Any,
            Side::Below => Self::Below,
            Side::Right => Self::Right,
            Side::Above => Self::Above,
            Side::Left => Self::Left,
        }
    }
}
