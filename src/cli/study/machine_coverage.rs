//! `shadowgauge study machine-coverage`: whether the uncertainty of an identified machine holds.

use std::path::PathBuf;

use super::shard::ShardArgs;
use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::{ConfigText, json_text};
use crate::cli::terminal::progress;
use crate::config;
use crate::identification::IdentificationConfig;
use crate::setting::SettingError;
use crate::studies::machine_coverage::{CoverageRow, MachineCoverage, MachineCoveragePlan, machine_coverage};
use crate::studies::sharding::SceneStudy as _;

/// Arguments of `study machine-coverage`.
#[derive(Debug, clap::Args)]
pub(crate) struct StudyMachineCoverageArgs {
    /// A plan of readings, as configs/machine_coverage.toml; every set has a plan, none a file.
    config: PathBuf,
    /// Machines of the class that are drawn, read and identified.
    #[arg(long, value_name = "N", default_value_t = 4000)]
    machines: u32,
    /// A job, as configs/machine_run.toml: midlines are read in rendered frames of its part before
    /// its camera, at its angles and the places of the plan, one sweep forward, on the CPU.
    #[arg(long, value_name = "JOB.toml")]
    frames: Option<PathBuf>,
    /// Seed of the draws.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    sharding: ShardArgs,
}

/// Runs the study, or one of its shards; exit 1 where the share of all figures together lies
/// outside 94 to 96 %, through frames by more than twice its standard deviation.
///
/// # Errors
/// Exit 2 for a config that is refused.
pub(crate) fn run(args: &StudyMachineCoverageArgs) -> CommandResult {
    let text = ConfigText::read(&args.config)?;
    let config: IdentificationConfig = text.parse()?;
    let frames = args.frames.as_deref().map(config::load).transpose().map_err(Failure::refused)?;
    let plan = MachineCoveragePlan { config, machines: args.machines, seed: args.seed, frames };
    let refused =
        |e: SettingError| if e.key.starts_with("--") { Failure::refuse(e) } else { text.refuse_at(e) };
    plan.bench().map_err(refused)?;
    if let Some(shard) = args.sharding.run(&plan) {
        return shard;
    }
    let bar = progress::bar(u64::from(args.machines), "drawing and identifying", "machines");
    let found = machine_coverage(&plan, &|| bar.inc(1)).map_err(refused)?;
    bar.finish_and_clear();
    say(&found, args.json)
}

/// Prints the study.
///
/// # Errors
/// Figures that JSON cannot represent.
pub(super) fn say(found: &MachineCoverage, json: bool) -> CommandResult {
    if json {
        say_line!("{}", json_text(found)?);
    } else {
        print(found);
    }
    Ok(if found.holds() { Outcome::Done } else { Outcome::OutOfTolerance })
}

fn print(found: &MachineCoverage) {
    say_line!(
        "{} machines of the class, identified from their simulated readings{}; deviations from the truth, µm",
        found.machines,
        if found.through_frames { ", midlines through frames" } else { "" }
    );
    say_line!(
        "{:<52} {:>8} {:>11} {:>9} {:>9} {:>13}",
        "figure",
        "values",
        "within 2u",
        "rms off",
        "rms u",
        "uncompensated"
    );
    found.figures.iter().for_each(print_row);
    print_row(&found.together);
    say_line!("standard deviation of the share of all figures: {:.2} %", found.scatter_percent);
}

fn print_row(row: &CoverageRow) {
    say_line!(
        "{:<52} {:>8} {:>9.2} % {:9.4} {:9.4} {:13.3}",
        row.figure,
        row.values,
        row.within_percent,
        row.rms_off_um,
        row.rms_u_um,
        row.rms_uncompensated_um
    );
}
