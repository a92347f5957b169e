//! What identifies a shard: shards that agree in all but their numbers belong together.

use super::shard_of::ShardOf;
use super::study::SceneStudy;
use crate::source::sha256_hex;

/// The identity of a shard, as its file states it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Identity {
    /// Name of the study, as on the command line.
    pub study: String,
    /// Version of the program: figures may change in their last digits with any.
    pub version: String,
    /// The study's settings as JSON.
    pub settings: String,
    /// SHA-256 of the settings, hexadecimal.
    pub settings_sha256: String,
    /// Seed of the study.
    pub seed: u64,
    /// Scenes of all shards together.
    pub scenes: u64,
    /// Which shard it is.
    pub shard: ShardOf,
}

impl Identity {
    /// Of a shard of a study.
    ///
    /// # Errors
    /// Settings that JSON cannot hold.
    pub(crate) fn of<S: SceneStudy>(study: &S, shard: ShardOf) -> Result<Self, serde_json::Error> {
        let settings = serde_json::to_string(study)?;
        Ok(Self {
            study: S::NAME.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            settings_sha256: sha256_hex(&settings),
            settings,
            seed: study.seed(),
            scenes: study.scenes(),
            shard,
        })
    }

    /// Scenes of this shard.
    pub(crate) fn own_scenes(&self) -> impl Iterator<Item = u64> + Clone {
        self.shard.scenes(self.scenes)
    }

    /// In what this shard differs from another that it should belong to; none where they belong
    /// together.
    pub(crate) fn differs(&self, other: &Self) -> Option<String> {
        let text = |what: &str, own: &str, others: &str| {
            (own != others).then(|| format!("{what} is {own}, not {others}"))
        };
        let number = |what: &str, own: u64, others: u64| text(what, &own.to_string(), &others.to_string());
        text("its study", &self.study, &other.study)
            .or_else(|| text("its program's version", &self.version, &other.version))
            .or_else(|| number("its seed", self.seed, other.seed))
            .or_else(|| number("the number of its scenes", self.scenes, other.scenes))
            .or_else(|| text("its config", &self.settings, &other.settings))
            .or_else(|| text("its config's SHA-256", &self.settings_sha256, &other.settings_sha256))
            .or_else(|| number("the number of its shards", self.shard.of, other.shard.of))
    }
}
