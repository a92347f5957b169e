//! Texts of the rows of a budget, where they are wanted.

use std::fmt::Arguments;

/// Whether the rows of a budget have their texts; their sums alone need none, and writing them
/// takes memory for every frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Texts {
    /// Source and input of every row.
    Written,
    /// Empty.
    LeftOut,
}

impl Texts {
    /// A text, or an empty one.
    pub(crate) fn of(self, text: Arguments<'_>) -> String {
        if self == Self::Written { text.to_string() } else { String::new() }
    }
}
