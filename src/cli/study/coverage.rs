//! `shadowgauge study coverage`: whether stated intervals cover the true diameters, in rendered and
//! measured scenes.

use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::terminal::progress;
use crate::render::{BackendChoice, Renderer};
use crate::studies::coverage::{Class, ClassFigures, class_figures, coverage, scenes_in_all};

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
}

/// Runs the study; exit 1 where a figure is missed.
///
/// # Errors
/// Exit 3 where a scene cannot be rendered or its masters cannot be measured.
pub(crate) fn run(args: &StudyCoverageArgs) -> CommandResult {
    let renderer = Renderer::new(BackendChoice::Cpu).map_err(Failure::fail)?;
    if !args.classes.is_empty() {
        return only(args, &renderer);
    }
    let bar = progress::bar(scenes_in_all(args.scenes) as u64, "drawing and measuring", "scenes");
    let result = coverage(args.scenes, args.seed, &renderer, &|| bar.inc(1)).map_err(Failure::fail)?;
    bar.finish_and_clear();
    let misses = result.misses(0.0);
    if args.json {
        say_line!("{}", serde_json::json!({ "coverage": result, "misses": misses }));
    } else {
        let wanted = "drawn from the budget's own distributions (94-96 % covered in all, 92 % a class)";
        table(wanted, &result.drawn, Some(&result.drawn_together));
        let wanted = "deviating inside the declared limits (95 % covered, U/p95 at most 1.5)";
        table(wanted, &result.deviating, Some(&result.deviating_together));
        let wanted = "round parts drawn from the rows of their limbs (94-96 % covered, U/p95 at most 1.3)";
        table(wanted, &result.limbs, Some(&result.limbs_together));
        table(
            "outside the limits, detectable (99 % flagged; in other light flagged or covered)",
            &result.detectable,
            None,
        );
        table("outside the limits, no frame shows it", &result.undetectable, None);
        for miss in &misses {
            say_line!("MISSED  {miss}");
        }
    }
    if misses.is_empty() {
        return Ok(Outcome::Done);
    }
    tracing::error!(
        "{} of the study's limits are missed with {} scenes (exit 1): {}",
        misses.len(),
        args.scenes,
        misses.join("; ")
    );
    Ok(Outcome::OutOfTolerance)
}

fn at_least_one(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|n| *n > 0).ok_or_else(|| "a number of at least 1 is needed".to_owned())
}

fn class(name: &str) -> Result<Class, String> {
    let found = Class::all().find(|c| format!("{c:?}").eq_ignore_ascii_case(name));
    found.ok_or_else(|| format!("no such class; there are {:?}", Class::all().collect::<Vec<_>>()))
}

/// Classes by name, without a verdict.
fn only(args: &StudyCoverageArgs, renderer: &Renderer) -> CommandResult {
    let scenes = args.classes.len() * args.scenes;
    let bar = progress::bar(scenes as u64, "drawing and measuring", "scenes");
    let run = |class: &Class| class_figures(*class, args.scenes, args.seed, renderer, &|| bar.inc(1));
    let figures = args.classes.iter().map(run).collect::<Result<Vec<_>, _>>().map_err(Failure::fail)?;
    bar.finish_and_clear();
    if args.json {
        say_line!("{}", serde_json::json!({ "classes": figures }));
    } else {
        table("classes asked for", &figures, None);
    }
    Ok(Outcome::Done)
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
