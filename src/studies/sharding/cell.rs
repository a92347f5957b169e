//! Rows of a shard's table.

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ColumnKind {
    /// UTF-8 text.
    Text,
    /// Whole numbers.
    Int,
    /// Whether something holds.
    Bool,
    /// Floating point; empty where there is none.
    Double,
}

/// Columns by name, with units in the names.
pub(crate) type Columns = &'static [(&'static str, ColumnKind)];

/// A value of a row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Cell {
    /// Of a column of text.
    Text(String),
    /// Of a column of whole numbers.
    Int(i64),
    /// Of a column of truths.
    Bool(bool),
    /// Of a column of floating point.
    Double(Option<f64>),
}

impl Cell {
    /// The kind of column that it stands in.
    pub(crate) fn kind(&self) -> ColumnKind {
        match self {
            Self::Text(_) => ColumnKind::Text,
            Self::Int(_) => ColumnKind::Int,
            Self::Bool(_) => ColumnKind::Bool,
            Self::Double(_) => ColumnKind::Double,
        }
    }
}
