//! `shadowgauge study merge`: the shards of a study, joined; prints what the study prints that was
//! not split.

use std::path::PathBuf;

use super::shard::read;
use super::{contamination, coverage, machine_coverage};
use crate::cli::failure::{CommandResult, Failure};
use crate::studies::contamination_plan::ContaminationPlan;
use crate::studies::coverage::CoveragePlan;
use crate::studies::machine_coverage::MachineCoveragePlan;
use crate::studies::sharding::{SceneStudy, joined};

/// Arguments of `study merge`.
#[derive(Debug, clap::Args)]
pub(crate) struct StudyMergeArgs {
    /// The files of all N shards, in any order.
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Joins the shards of a study.
///
/// # Errors
/// As the study; exit 2 for shards that do not belong together, come twice or are missing, and for
/// files that are none.
pub(crate) fn run(args: &StudyMergeArgs) -> CommandResult {
    let shards = args.files.iter().map(|path| read(path)).collect::<Result<Vec<_>, _>>()?;
    let study = shards.first().map(|shard| shard.identity.study.as_str()).unwrap_or_default();
    match study {
        CoveragePlan::NAME => {
            let (plan, outcomes) = joined::<CoveragePlan>(&shards).map_err(Failure::refuse)?;
            coverage::say(&plan, &outcomes, args.json)
        }
        ContaminationPlan::NAME => {
            let (plan, outcomes) = joined::<ContaminationPlan>(&shards).map_err(Failure::refuse)?;
            contamination::say(&plan.result(&outcomes), args.json)
        }
        MachineCoveragePlan::NAME => {
            let (plan, machines) = joined::<MachineCoveragePlan>(&shards).map_err(Failure::refuse)?;
            machine_coverage::say(&plan.result(&machines), args.json)
        }
        other => Err(Failure::refuse(format!(
            "{}: a shard of the study {other:?}, which this version cannot split; it splits {}, {} and {}",
            args.files.first().map(|file| file.display().to_string()).unwrap_or_default(),
            CoveragePlan::NAME,
            ContaminationPlan::NAME,
            MachineCoveragePlan::NAME
        ))),
    }
}
