//! Shards, checked and joined.

use std::collections::BTreeSet;

use thiserror::Error;

use super::cell::Cell;
use super::identity::Identity;
use super::shard_of::ShardOf;
use super::study::SceneStudy;
use crate::source::sha256_hex;

/// A shard as it was read.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shard {
    /// The file, in errors.
    pub file: String,
    /// What it states of itself.
    pub identity: Identity,
    /// Its rows: the number of a scene, and its outcome.
    pub rows: Vec<(u64, Vec<Cell>)>,
}

/// Why shards cannot be joined.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub(crate) enum JoinError {
    /// No shard at all.
    #[error("no shard is given")]
    None,
    /// A shard of another study, config, seed or number of shards.
    #[error(
        "{file} does not belong to {first}: {difference}. Shards are joined that have the same study, \
         config, seed and number of shards"
    )]
    Foreign {
        /// The file.
        file: String,
        /// The file that the others are compared with.
        first: String,
        /// In what they differ.
        difference: String,
    },
    /// A shard whose settings are not those that it states the hash of.
    #[error("{file}: its config is not the one whose SHA-256 it states: it was changed or is damaged")]
    Changed {
        /// The file.
        file: String,
    },
    /// A shard twice.
    #[error("{file} and {first} are both shard {shard}: give each once")]
    Twice {
        /// The file.
        file: String,
        /// The file before it.
        first: String,
        /// The shard, in words.
        shard: String,
    },
    /// Shards that are not there.
    #[error("of {of} shards these are missing: {}; make each with --shard I/{of}", some_of(.missing))]
    Missing {
        /// Their numbers.
        missing: Vec<u64>,
        /// Shards in all.
        of: u64,
    },
    /// A shard whose rows are not those of its scenes.
    #[error("{file}: {what}: it is damaged; remove it and make shard {shard} again")]
    Rows {
        /// The file.
        file: String,
        /// What is wrong.
        what: String,
        /// The shard, in words.
        shard: String,
    },
    /// Settings that this version of the program cannot read.
    #[error("{file}: its config cannot be read: {cause}")]
    Settings {
        /// The file.
        file: String,
        /// What is wrong.
        cause: String,
    },
}

/// The first numbers of a list.
fn some_of(numbers: &[u64]) -> String {
    /// As many as a line of a terminal holds.
    const SHOWN: usize = 12;
    let shown: Vec<String> = numbers.iter().take(SHOWN).map(u64::to_string).collect();
    let more = if numbers.len() > SHOWN { ", …" } else { "" };
    shown.join(", ") + more
}

/// Checks that a shard holds its own scenes, each once and in their order.
///
/// # Errors
/// The first scene that is missing or foreign.
pub(crate) fn check_rows(shard: &Shard) -> Result<(), JoinError> {
    let damaged = |what: String| JoinError::Rows {
        file: shard.file.clone(),
        what,
        shard: shard.identity.shard.to_string(),
    };
    if sha256_hex(&shard.identity.settings) != shard.identity.settings_sha256 {
        return Err(JoinError::Changed { file: shard.file.clone() });
    }
    let expected = shard.identity.own_scenes();
    let (found, wanted) = (shard.rows.len(), expected.clone().count());
    if found != wanted {
        return Err(damaged(format!("it has {found} scenes, not {wanted}")));
    }
    match shard.rows.iter().zip(expected).find(|((number, _), expected)| number != expected) {
        Some(((number, _), expected)) => {
            Err(damaged(format!("scene {number} stands where {expected} belongs")))
        }
        None => Ok(()),
    }
}

/// Checks that shards belong together and are all there.
///
/// # Errors
/// The first that does not belong to the first one, that comes twice or is damaged; those missing.
fn check(shards: &[Shard]) -> Result<(), JoinError> {
    let first = shards.first().ok_or(JoinError::None)?;
    for (index, shard) in shards.iter().enumerate() {
        if let Some(difference) = shard.identity.differs(&first.identity) {
            let (file, first) = (shard.file.clone(), first.file.clone());
            return Err(JoinError::Foreign { file, first, difference });
        }
        let number = shard.identity.shard.number;
        if let Some(before) = shards[..index].iter().find(|s| s.identity.shard.number == number) {
            let (file, first) = (shard.file.clone(), before.file.clone());
            return Err(JoinError::Twice { file, first, shard: shard.identity.shard.to_string() });
        }
        check_rows(shard)?;
    }
    let of = first.identity.shard.of;
    let there: BTreeSet<u64> = shards.iter().map(|s| s.identity.shard.number).collect();
    let missing: Vec<u64> = (1..=of).filter(|number| !there.contains(number)).collect();
    if missing.is_empty() { Ok(()) } else { Err(JoinError::Missing { missing, of }) }
}

/// The study of shards that belong together, and the outcomes of all its scenes in their order.
///
/// # Errors
/// Shards of different studies, configs, seeds or numbers of shards; one that comes twice, is
/// missing or is damaged.
pub(crate) fn joined<S: SceneStudy>(shards: &[Shard]) -> Result<(S, Vec<S::Outcome>), JoinError> {
    check(shards)?;
    let first = shards.first().ok_or(JoinError::None)?;
    let settings = |cause: String| JoinError::Settings { file: first.file.clone(), cause };
    let study: S = serde_json::from_str(&first.identity.settings).map_err(|e| settings(e.to_string()))?;
    let own = Identity::of(&study, ShardOf { number: 1, of: first.identity.shard.of });
    let own = own.map_err(|e| settings(e.to_string()))?;
    if let Some(difference) = first.identity.differs(&own) {
        return Err(settings(format!("{difference}: another version of the program made it")));
    }
    let mut by_scene: Vec<Option<S::Outcome>> = Vec::new();
    by_scene.resize_with(usize::try_from(study.scenes()).unwrap_or(0), || None);
    for shard in shards {
        for (number, row) in &shard.rows {
            let damaged = || JoinError::Rows {
                file: shard.file.clone(),
                what: format!("scene {number} has other columns"),
                shard: shard.identity.shard.to_string(),
            };
            let outcome = S::outcome(row).ok_or_else(damaged)?;
            *usize::try_from(*number).ok().and_then(|at| by_scene.get_mut(at)).ok_or_else(damaged)? =
                Some(outcome);
        }
    }
    Ok((study, by_scene.into_iter().flatten().collect()))
}
