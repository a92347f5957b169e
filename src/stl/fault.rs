//! Why a model is no turned part, and where.

use std::fmt;

use glam::DVec3;

/// What is wrong with a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FaultKind {
    /// The bytes are no STL.
    File,
    /// No facet with an area.
    Empty,
    /// An edge of one facet alone.
    Open,
    /// An edge of three facets or more.
    NonManifold,
    /// Neighbouring facets whose outsides are not on one side.
    Orientation,
    /// Bodies or cavities that share no edge.
    SeveralBodies,
    /// A body about which several axes fit.
    NoAxis,
    /// A surface whose normals pass the axis.
    OffAxis,
    /// Vertices of a turn that differ in radius or in Z.
    Scatter,
    /// A turn of fewer than 12 vertices.
    FewVertices,
    /// Chords that stand too far inside of their circle.
    Sagitta,
    /// A profile that crosses itself.
    SelfCrossing,
    /// A size that does not fit the bar in the unit stated.
    Unit,
}

/// A model that is refused: what, where in the file's own axes, why and what would be right.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ModelFault {
    /// What is wrong.
    pub kind: FaultKind,
    /// A point of the place, mm in the axes of the file; none where the whole file is meant.
    pub at: Option<DVec3>,
    /// In words, with what would be right.
    pub why: String,
}

impl ModelFault {
    /// A fault of the file as a whole.
    pub(super) fn whole(kind: FaultKind, why: impl Into<String>) -> Self {
        Self { kind, at: None, why: why.into() }
    }

    /// A fault at a place.
    pub(super) fn at(kind: FaultKind, at: DVec3, why: impl Into<String>) -> Self {
        Self { kind, at: Some(at), why: why.into() }
    }
}

impl fmt::Display for ModelFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(at) = self.at {
            write!(f, "at ({:.3}, {:.3}, {:.3}) mm of the model: ", at.x, at.y, at.z)?;
        }
        f.write_str(&self.why)
    }
}

impl std::error::Error for ModelFault {}
