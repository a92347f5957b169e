//! How many columns of a frame have which reason.

use serde::ser::SerializeMap as _;
use serde::{Serialize, Serializer};

use crate::profile::Reason;

/// Columns by the reason that they are gaps or impaired, in the order of the reasons' words. JSON:
/// `{"reason": columns}`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Flags {
    counts: Vec<(Reason, usize)>,
}

impl Flags {
    /// Counts so many more columns with a reason.
    pub(crate) fn add(&mut self, reason: Reason, columns: usize) {
        let place = self.counts.binary_search_by(|(known, _)| known.as_str().cmp(reason.as_str()));
        match place {
            Ok(at) => self.counts[at].1 += columns,
            Err(at) => self.counts.insert(at, (reason, columns)),
        }
    }

    /// Columns with a reason.
    pub fn of(&self, reason: Reason) -> usize {
        self.iter().find(|(known, _)| *known == reason).map_or(0, |(_, columns)| columns)
    }

    /// Reasons with their columns.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (Reason, usize)> {
        self.counts.iter().copied()
    }

    /// Counts exactly so many columns with a reason.
    pub(super) fn set(&mut self, reason: Reason, columns: usize) {
        self.counts.retain(|(known, _)| *known != reason);
        self.add(reason, columns);
    }

    /// No column any more; keeps the memory.
    pub(super) fn clear(&mut self) {
        self.counts.clear();
    }
}

impl Serialize for Flags {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.counts.len()))?;
        for (reason, columns) in self.iter() {
            map.serialize_entry(reason.as_str(), &columns)?;
        }
        map.end()
    }
}
