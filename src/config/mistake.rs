//! A mistake in a config: what is wrong at which place, and what to write in its stead.

use std::ops::Range;

/// A mistake of a user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Mistake {
    /// Its place in the text.
    pub span: Range<usize>,
    /// Dotted key; empty where there is none.
    pub key: String,
    /// What is wrong.
    pub what: String,
    /// What to write.
    pub remedy: Option<String>,
}

impl Mistake {
    /// Key and what is wrong.
    pub(super) fn message(&self) -> String {
        if self.key.is_empty() { self.what.clone() } else { format!("{}: {}", self.key, self.what) }
    }
}
