//! `shadowgauge reproduce 003`: the slender-shaft paper.

use std::path::PathBuf;

use super::paper_003_page;
use super::tables;
use crate::cli::failure::{CommandResult, Failure};
use crate::cli::input_output::{ConfigText, StudyFolder};
use crate::cli::terminal::progress;
use crate::render::{BackendChoice, Renderer};
use crate::studies::optimize::OptimizeConfig;
use crate::studies::reproduce_003::{self, Inputs};

const INPUTS: &str = include_str!("../../../configs/reproduce_003.toml");
const PROBLEM: &str = include_str!("../../../configs/optimize_003.toml");

/// Arguments of `reproduce 003`.
#[derive(Debug, clap::Args)]
pub(crate) struct Reproduce003Args {
    /// What the paper prints, in place of configs/reproduce_003.toml as the binary carries it.
    #[arg(long, value_name = "TOML")]
    inputs: Option<PathBuf>,
    /// The choice of cutting data, in place of configs/optimize_003.toml as the binary carries it.
    #[arg(long, value_name = "TOML")]
    problem: Option<PathBuf>,
    /// Leave out the rows of Fig. 11 that are measured on rendered frames.
    #[arg(long)]
    no_frames: bool,
    /// Where frames are rendered.
    #[arg(long, value_enum, default_value_t = BackendChoice::Auto)]
    backend: BackendChoice,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write report.html, rows.csv and plots into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Computes every row.
///
/// # Errors
/// Exit 2 for inputs that are refused, 3 for a device or a disk that fails.
pub(crate) fn run(args: &Reproduce003Args) -> CommandResult {
    let inputs_text = ConfigText::read_or(args.inputs.as_deref(), "configs/reproduce_003.toml", INPUTS)?;
    let problem_text = ConfigText::read_or(args.problem.as_deref(), "configs/optimize_003.toml", PROBLEM)?;
    let inputs: Inputs = inputs_text.parse()?;
    let problem: OptimizeConfig = problem_text.parse()?;
    problem.validate().map_err(|e| problem_text.refuse(e))?;
    let folder = StudyFolder::claim(args.out.as_deref())?;
    let renderer =
        (!args.no_frames).then(|| Renderer::new(args.backend)).transpose().map_err(Failure::fail)?;
    let steps = reproduce_003::steps_in_all(renderer.is_some());
    let bar = progress::bar(steps as u64, "reproducing", "steps");
    let found = reproduce_003::run(&inputs, &problem, renderer.as_ref(), &|| bar.inc(1));
    bar.finish_and_clear();
    let found = found.map_err(|e| inputs_text.refuse(e))?;
    StudyFolder::fill(folder, |folder| paper_003_page::write(folder, &found))?;
    tables::print(&found.rows, args.json)
}
