//! Columns of a table.

/// Values of a column.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Values {
    /// Floating point; NaN where there is none.
    Double(Vec<f64>),
    /// Whole numbers.
    Int(Vec<i64>),
    /// Texts; empty where there is none.
    Text(Vec<String>),
}

impl Values {
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Double(values) => values.len(),
            Self::Int(values) => values.len(),
            Self::Text(values) => values.len(),
        }
    }
}

/// A column by its name, with its unit in it.
pub(crate) type Column = (&'static str, Values);
