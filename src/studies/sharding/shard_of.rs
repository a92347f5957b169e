//! Shard i of N, and the scenes that are its own.

use std::fmt;
use std::str::FromStr;

/// Most shards of a study: file names have room for as many, and a table a scene serves no one.
pub(crate) const MOST_SHARDS: u64 = 999_999;

/// Shard i of N, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ShardOf {
    /// i, from 1 to N.
    pub number: u64,
    /// N.
    pub of: u64,
}

impl ShardOf {
    /// The numbers of its scenes among so many, from 0: every N-th one, so that the kinds of
    /// scenes, which take unequally long, are shared out evenly.
    pub(crate) fn scenes(self, in_all: u64) -> impl Iterator<Item = u64> + Clone {
        (self.number - 1..in_all).step_by(usize::try_from(self.of).unwrap_or(usize::MAX))
    }
}

impl FromStr for ShardOf {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            format!(
                "{text:?} is no shard; right is I/N with I from 1 to N and N at most {MOST_SHARDS}, as 2/7"
            )
        };
        let (number, of) = text.split_once('/').ok_or_else(wrong)?;
        let (number, of) = (number.parse().map_err(|_| wrong())?, of.parse().map_err(|_| wrong())?);
        if of > MOST_SHARDS || !(1..=of).contains(&number) {
            return Err(wrong());
        }
        Ok(Self { number, of })
    }
}

impl fmt::Display for ShardOf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {}", self.number, self.of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_share_out_every_scene_once() {
        for (of, scenes) in [(1, 5), (3, 10), (7, 3)] {
            let each = (1..=of).flat_map(|number| ShardOf { number, of }.scenes(scenes));
            let mut all: Vec<u64> = each.collect();
            all.sort_unstable();
            assert_eq!(all, (0..scenes).collect::<Vec<_>>(), "{of} shards");
        }
    }

    #[test]
    fn a_shard_is_written_i_of_n() {
        assert_eq!("2/7".parse(), Ok(ShardOf { number: 2, of: 7 }));
        for wrong in ["", "2", "0/7", "8/7", "1/0", "-1/3", "1/1000000", "1/2/3", "a/b"] {
            let error = wrong.parse::<ShardOf>().unwrap_err();
            assert!(error.contains("I/N"), "{wrong}: {error}");
        }
    }
}
