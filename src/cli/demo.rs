//! `shadowgauge demo`: the main job with the built-in preset.

use std::path::{Path, PathBuf};

use crate::config;
use crate::render::BackendChoice;
use crate::run_folder::RunFolder;

use super::failure::{CommandResult, Failure, Outcome};
use super::process::interrupt;
use super::run::frames_from::FramesFrom;
use super::run::{Execution, execute};
use super::store::args::StoreArgs;

/// Arguments of `demo`.
#[derive(Debug, clap::Args)]
pub(crate) struct DemoArgs {
    /// Run folder; an earlier demo in it is replaced.
    #[arg(long, value_name = "DIR", default_value = "out/demo")]
    out: PathBuf,
    /// Where frames are rendered; auto takes a hardware adapter, else the CPU path (a software
    /// adapter only by name).
    #[arg(long, value_enum, default_value_t = BackendChoice::Auto)]
    backend: BackendChoice,
}

/// Runs the preset's slender shaft; replaces only an earlier result of its own.
///
/// # Errors
/// Exit 2 where the folder holds something else, 3 where a device or a disk fails.
pub(crate) fn run(args: &DemoArgs) -> CommandResult {
    let job = config::parse(config::SLENDER_SHAFT, "configs/slender_shaft.toml").map_err(Failure::refused)?;
    let resolved = config::resolved(&job).map_err(Failure::fail)?;
    clear_earlier(&args.out, &resolved)?;
    interrupt::end_with(format!(
        "interrupted: {} holds an unfinished demo; the next one starts anew",
        args.out.display()
    ));
    let from = FramesFrom::simulation(args.backend)?;
    let finished = execute(
        &job,
        &args.out,
        &Execution { from: &from, reference: true, record: None, store: &StoreArgs::default() },
    )?;
    say!("{}", finished.to_table());
    say_line!("report: {}", args.out.join("report.html").display());
    Ok(Outcome::Done)
}

/// Removes a run of this very preset (or of an earlier version's preset of the same name).
fn clear_earlier(out: &Path, resolved: &str) -> Result<(), Failure> {
    let name = |text: &str| text.lines().find(|l| l.starts_with("name = ")).map(str::to_owned);
    let own = name(resolved);
    RunFolder::clear(out, |earlier| name(earlier) == own).map_err(super::failure::folder_failure)
}
