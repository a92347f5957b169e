//! `shadowgauge study flank`: rendered flanks, measured, beside their stated uncertainties.

use std::path::PathBuf;

use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::{csv_text, json_text};
use crate::cli::terminal::progress;
use crate::cli::tool::flank::model;
use crate::cli::tool::nose::scale;
use crate::cli::tool::render_flank::size;
use crate::files::OutputFile;
use crate::gauge::flank::FlankSide;
use crate::studies::flanks::{self, FlankPlan, WidthErrors};
use crate::studies::worn_flanks;
use crate::tool::wear::WearLimits;

/// Arguments of `study flank`.
#[derive(Debug, clap::Args)]
pub(crate) struct StudyFlankArgs {
    /// Flanks: scenes drawn as those of `tool render-flank --random`.
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    flanks: u32,
    /// Instead: so many tools whose VBB or VBBmax lies within 12 % of its limit (ISO 3685), judged;
    /// how many that are blunt pass as sharp, by the stated u.
    #[arg(long, value_name = "N", conflicts_with = "flanks", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    tools: Option<u32>,
    /// `forest` (the shipped one) or a file of `tool train`.
    #[arg(long, value_name = "MODEL", default_value = "forest")]
    model: String,
    /// Size of the images.
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "900x560", value_parser = size)]
    size: (u32, u32),
    /// Scale, µm per px.
    #[arg(long, value_name = "S", default_value_t = 2.415, value_parser = scale)]
    um_per_px: f64,
    /// At which side of the edge the flank lies: below it in all of these scenes.
    #[arg(long, value_enum, default_value_t = FlankSide::Any)]
    flank_side: FlankSide,
    /// A row a flank.
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    /// Seed of the first scene; the others follow it. Others than those that the model has seen.
    #[arg(long, value_name = "N", default_value_t = 100_001)]
    seed: u64,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Runs the study.
///
/// # Errors
/// Exit 2 for a model or a size that is refused.
pub(crate) fn run(args: &StudyFlankArgs) -> CommandResult {
    let Some(model) = model::read(&args.model)? else {
        return Err(Failure::refuse(
            "--model paper states no uncertainty to compare with; give forest or a file",
        ));
    };
    let csv = args.csv.as_deref().map(|p| OutputFile::claim(p, [])).transpose()?;
    let plan = FlankPlan {
        model: model.as_ref(),
        size: args.size,
        um_per_px: args.um_per_px,
        seed: args.seed,
        side: args.flank_side,
    };
    if let Some(tools) = args.tools {
        return judged(args, &plan, (tools, csv));
    }
    let bar = progress::bar(u64::from(args.flanks), "measuring", "flanks");
    let rows = flanks::run(&plan, args.flanks as usize, &|| bar.inc(1)).map_err(Failure::refuse)?;
    bar.finish_and_clear();
    let summary = flanks::summary(&rows, args.um_per_px);
    if let Some(csv) = csv {
        csv.write(&csv_text(&rows)?)?;
    }
    if args.json {
        say_line!("{}", json_text(&serde_json::json!({ "summary": summary, "flanks": rows }))?);
        return Ok(Outcome::Done);
    }
    say_line!(
        "{} x {} px of {} µm: {} flanks measured, {} refused; errors in px",
        args.size.0,
        args.size.1,
        args.um_per_px,
        summary.measured,
        summary.refused
    );
    say_line!(
        "{:>7} {:>7} {:>7} {:>7} {:>8} {:>7} {:>7}",
        "",
        "rms",
        "median",
        "90 %",
        "largest",
        "u",
        "95 %"
    );
    for (name, of) in [("VBB", summary.vbb), ("VBBmax", summary.vbb_max)] {
        say_line!("{}", line(name, &of));
    }
    Ok(Outcome::Done)
}

/// Tools about the limits of ISO 3685.
fn judged(
    args: &StudyFlankArgs,
    plan: &FlankPlan<'_>,
    (count, csv): (u32, Option<OutputFile>),
) -> CommandResult {
    let limits = WearLimits::default();
    let bar = progress::bar(u64::from(count), "judging", "tools");
    let tools = worn_flanks::run(plan, &limits, (count as usize, &|| bar.inc(1))).map_err(Failure::refuse)?;
    bar.finish_and_clear();
    let bins = worn_flanks::bins(&tools, &limits);
    if let Some(csv) = csv {
        csv.write(&csv_text(&tools)?)?;
    }
    if args.json {
        say_line!("{}", json_text(&serde_json::json!({ "bins": bins, "tools": tools }))?);
        return Ok(Outcome::Done);
    }
    let refused = tools.iter().filter(|t| t.verdict.is_none()).count();
    say_line!(
        "{count} tools about VBB {} and VBBmax {} µm, {refused} refused",
        limits.vbb_um,
        limits.vbb_max_um
    );
    say_line!("{:>11} {:>8} {:>6} {:>15} {:>7}", "u to/µm", "measured", "blunt", "passed as sharp", "> 2 U");
    for bin in bins {
        let share = 100.0 * bin.passed as f64 / bin.blunt.max(1) as f64;
        say_line!(
            "{:>11.1} {:>8} {:>6} {:>7} {share:>5.1} % {:>7}",
            bin.to_u_um,
            bin.measured,
            bin.blunt,
            bin.passed,
            bin.beyond
        );
    }
    Ok(Outcome::Done)
}

fn line(name: &str, of: &WidthErrors) -> String {
    format!(
        "{name:>7} {:>7.2} {:>7.2} {:>7.2} {:>8.2} {:>7.2} {:>5.1} %",
        of.rms_px,
        of.median_px,
        of.ninety_percent_px,
        of.largest_px,
        of.u_px,
        100.0 * of.within
    )
}
