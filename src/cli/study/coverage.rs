//! `shadowgauge study coverage`: whether stated intervals cover the true diameters, in rendered and
//! measured scenes.

use super::shard::ShardArgs;
use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::terminal::progress;
use crate::studies::coverage::{
    Class, ClassFigures, Coverage, CoveragePlan, CoverageResult, Outcome as SceneOutcome,
};
use crate::studies::sharding::{SceneStudy, outcomes};

/// Arguments of `study coverage`.
#[derive(Debug, clap::Args)]
pub(crate) struct StudyCoverageArgs {
    /// Scenes drawn from the budget's own distributions; half as many are of round parts, a third
    /// as many deviate inside the limits, a quarter lie outside.
    #[arg(long, value_name = "N", default_value_t = 10_000, value_parser = at_least_one)]
    scenes: usize,
    /// Seed of the draws.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Only this class, with all the scenes (repeatable); the names are those of the tables.
    #[arg(long = "class", value_name = "NAME", value_parser = class)]
    classes: Vec<Class>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    sharding: ShardArgs,
}

impl StudyCoverageArgs {
    fn plan(&self) -> CoveragePlan {
        CoveragePlan { scenes: self.scenes, seed: self.seed, only: self.classes.clone() }
    }
}

/// Runs the study, or one of its shards; exit 1 where a figure is missed.
///
/// # Errors
/// Exit 3 where a scene cannot be rendered or its masters cannot be measured.
pub(crate) fn run(args: &StudyCoverageArgs) -> CommandResult {
    let plan = args.plan();
    if let Some(shard) = args.sharding.run(&plan) {
        return shard;
    }
    let renderer = plan.bench().map_err(Failure::fail)?;
    let bar = progress::bar(plan.scenes(), "drawing and measuring", "scenes");
    let found = outcomes(&plan, &renderer, 0..plan.scenes(), &|| bar.inc(1)).map_err(Failure::fail)?;
    bar.finish_and_clear();
    say(&plan, &found, args.json)
}

/// Prints the figures of all scenes' outcomes; exit 1 where one is missed.
///
/// # Errors
/// None.
pub(super) fn say(plan: &CoveragePlan, outcomes: &[SceneOutcome], json: bool) -> CommandResult {
    match plan.result(outcomes) {
        CoverageResult::Whole(result) => say_whole(&result, plan.scenes, json),
        CoverageResult::Only(figures) => {
            if json {
                say_line!("{}", serde_json::json!({ "classes": figures }));
            } else {
                table("classes asked for", &figures, None);
            }
            Ok(Outcome::Done)
        }
    }
}

fn say_whole(result: &Coverage, scenes: usize, json: bool) -> CommandResult {
    let misses = result.misses(0.0);
    if json {
        say_line!("{}", serde_json::json!({ "coverage": result, "misses": misses }));
    } else {
        say_tables(result);
        for miss in &misses {
            say_line!("MISSED  {miss}");
        }
    }
    if misses.is_empty() {
        return Ok(Outcome::Done);
    }
    tracing::error!(
        "{} of the study's limits are missed with {scenes} scenes (exit 1): {}",
        misses.len(),
        misses.join("; ")
    );
    Ok(Outcome::OutOfTolerance)
}

fn say_tables(result: &Coverage) {
    let wanted = "drawn from the budget's own distributions (94-96 % covered in all, 92 % a class)";
    table(wanted, &result.drawn, Some(&result.drawn_together));
    let wanted = "deviating inside the declared limits (95 % covered, U/p95 at most 1.5)";
    table(wanted, &result.deviating, Some(&result.deviating_together));
    let wanted = "round parts drawn from the rows of their limbs (94-96 % covered, U/p95 at most 1.3)";
    table(wanted, &result.limbs, Some(&result.limbs_together));
    let wanted = "outside the limits, detectable (99 % flagged; in other light flagged or covered)";
    table(wanted, &result.detectable, None);
    table("outside the limits, no frame shows it", &result.undetectable, None);
}

fn at_least_one(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|n| *n > 0).ok_or_else(|| "a number of at least 1 is needed".to_owned())
}

fn class(name: &str) -> Result<Class, String> {
    let found = Class::all().find(|c| format!("{c:?}").eq_ignore_ascii_case(name));
    found.ok_or_else(|| format!("no such class; there are {:?}", Class::all().collect::<Vec<_>>()))
}

/// Prints classes, with the row of all of them together where there is one, and the declaration of
/// each.
fn table(title: &str, classes: &[ClassFigures], together: Option<&ClassFigures>) {
    say_line!(
        "{title}\n{:<16} {:>7} {:>9} {:>10} {:>10} {:>11} {:>11} {:>9} {:>12}",
        "class",
        "scenes",
        "accepted",
        "covered %",
        "flagged %",
        "mean U um",
        "p95 |e| um",
        "U/p95",
        "rms e/u"
    );
    for c in classes.iter().chain(together) {
        // Where every scene is flagged there is no interval that could cover.
        let accepted = |value: f64, digits: usize| match c.accepted {
            0 => "-".to_owned(),
            _ => format!("{value:.digits$}"),
        };
        say_line!(
            "{:<16} {:>7} {:>9} {:>10} {:>10.2} {:>11} {:>11} {:>9} {:>12}",
            c.name(),
            c.scenes,
            c.accepted,
            accepted(1e2 * c.covered, 2),
            1e2 * c.flagged,
            accepted(c.mean_half_um, 4),
            accepted(c.p95_error_um, 4),
            accepted(c.half_over_p95(), 2),
            accepted(c.rms_error_over_u, 3)
        );
        if c.class.is_some() {
            for (reason, count) in &c.flags {
                say_line!("{:<16} {count} flagged: {reason}", "");
            }
        }
    }
    for class in classes.iter().filter_map(|c| c.class) {
        say_line!("  {class:?}: {}", class.declared());
    }
    say_line!();
}
