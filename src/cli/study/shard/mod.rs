//! `study NAME --shard I/N`: a part of a study's scenes, as a Parquet file; `study merge` joins the
//! files.
//!
//! A shard is computed whole and appears under its name once it is written; one that is there
//! already is checked and left. `table` is the file.

mod table;

use std::path::{Path, PathBuf};

use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::terminal::progress;
use crate::files::{OutputFile, make_folder};
use crate::studies::sharding::{Identity, SceneStudy, Shard, ShardOf, check_rows, outcomes};
pub(super) use table::read;

/// Arguments of a study that can be split.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct ShardArgs {
    /// Only the scenes of shard I of N, into a Parquet file; `study merge` joins the N files. A
    /// shard that is there already is checked and left.
    #[arg(long, value_name = "I/N")]
    shard: Option<ShardOf>,
    /// Folder of the shards' files.
    #[arg(long, value_name = "DIR", default_value = ".")]
    shard_dir: PathBuf,
}

impl ShardArgs {
    /// Makes the shard that is asked for; none where the whole study is.
    ///
    /// # Errors
    /// Exit 2 for a file in its place that is another shard or none; 3 for scenes and disks that
    /// fail.
    pub(super) fn run<S: SceneStudy>(&self, study: &S) -> Option<CommandResult> {
        self.shard.map(|shard| make(study, shard, &self.shard_dir))
    }
}

/// Name of a shard's file.
fn file_name(study: &str, shard: ShardOf) -> String {
    let digits = shard.of.to_string().len();
    format!("{study}-{:0digits$}-of-{}.parquet", shard.number, shard.of)
}

fn make<S: SceneStudy>(study: &S, shard: ShardOf, folder: &Path) -> CommandResult {
    let identity = Identity::of(study, shard).map_err(Failure::fail)?;
    let path = folder.join(file_name(S::NAME, shard));
    let scenes = identity.own_scenes().count();
    if path.exists() {
        check_there(&path, &identity)?;
        say_line!("{}: shard {shard} is there, {scenes} scenes", path.display());
        return Ok(Outcome::Done);
    }
    make_folder(folder)?;
    let file = OutputFile::claim(&path, [])?;
    let bench = study.bench().map_err(Failure::fail)?;
    let bar = progress::bar(scenes as u64, "drawing and measuring", "scenes");
    let found = outcomes(study, &bench, identity.own_scenes(), &|| bar.inc(1)).map_err(Failure::fail)?;
    bar.finish_and_clear();
    let rows = identity.own_scenes().zip(found.iter().map(S::row)).collect();
    let shard_file = Shard { file: path.display().to_string(), identity, rows };
    file.write(&table::encode(S::COLUMNS, &shard_file).map_err(Failure::fail)?)?;
    say_line!("{}: shard {shard}, {scenes} scenes", path.display());
    Ok(Outcome::Done)
}

/// Checks the file that stands in a shard's place.
fn check_there(path: &Path, identity: &Identity) -> Result<(), Failure> {
    let there = read(path)?;
    if let Some(difference) = there.identity.differs(identity) {
        return Err(Failure::refuse(format!(
            "{} is another shard: {difference}; give another --shard-dir, or remove it",
            path.display()
        )));
    }
    if there.identity.shard != identity.shard {
        return Err(Failure::refuse(format!(
            "{} is shard {}, not {}: it was renamed; remove it",
            path.display(),
            there.identity.shard,
            identity.shard
        )));
    }
    check_rows(&there).map_err(Failure::refuse)
}
