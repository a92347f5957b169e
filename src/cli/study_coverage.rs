//! `shadowgauge study coverage`: whether stated intervals cover the true diameters, in rendered and measured scenes.

use super::{CommandResult, Failure, Outcome};
use crate::render::{BackendChoice, Renderer};
use crate::studies::coverage::{Class, ClassFigures, class_figures, coverage};

/// Arguments of `study coverage`.
#[derive(Debug, clap::Args)]
pub struct StudyCoverageArgs {
    /// Scenes drawn from the budget's own distributions; a third as many deviate inside the limits, a quarter lie outside.
    #[arg(long, value_name = "N", default_value_t = 10_000)]
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
/// Exit 3 where a scene cannot be rendered or its masters not be measured.
pub fn run(args: &StudyCoverageArgs) -> CommandResult {
    let renderer = Renderer::new(BackendChoice::Cpu).map_err(Failure::fail)?;
    if !args.classes.is_empty() {
        return only(args, &renderer);
    }
    let result = coverage(args.scenes, args.seed, &renderer).map_err(Failure::fail)?;
    let misses = result.misses(0.0);
    if args.json {
        println!("{}", serde_json::json!({ "coverage": result, "misses": misses }));
    } else {
        table("drawn from the budget's own distributions", &result.drawn);
        println!("all of them: {:.2} % covered (wanted 94 to 96)\n", 1e2 * result.drawn_covered);
        table("deviating inside the declared limits", &result.deviating);
        table("outside the limits, detectable", &result.detectable);
        table("outside the limits, no frame shows it", &result.undetectable);
        for miss in &misses {
            println!("MISSED  {miss}");
        }
    }
    Ok(if misses.is_empty() { Outcome::Done } else { Outcome::OutOfTolerance })
}

fn class(name: &str) -> Result<Class, String> {
    let found = Class::all().find(|c| format!("{c:?}").eq_ignore_ascii_case(name));
    found.ok_or_else(|| format!("no such class; there are {:?}", Class::all().collect::<Vec<_>>()))
}

/// Classes by name, without a verdict.
fn only(args: &StudyCoverageArgs, renderer: &Renderer) -> CommandResult {
    let run = |class: &Class| class_figures(*class, args.scenes, args.seed, renderer);
    let figures = args.classes.iter().map(run).collect::<Result<Vec<_>, _>>().map_err(Failure::fail)?;
    if args.json {
        println!("{}", serde_json::json!({ "classes": figures }));
    } else {
        table("classes asked for", &figures);
    }
    Ok(Outcome::Done)
}

fn table(title: &str, classes: &[ClassFigures]) {
    println!(
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
    for c in classes {
        println!(
            "{:<16} {:>7} {:>9} {:>10.2} {:>10.2} {:>11.4} {:>11.4} {:>9.2} {:>12.3}",
            format!("{:?}", c.class),
            c.scenes,
            c.accepted,
            1e2 * c.covered,
            1e2 * c.flagged,
            c.mean_half_um,
            c.p95_error_um,
            c.mean_half_um / c.p95_error_um,
            c.rms_error_over_u
        );
        for (reason, count) in &c.flags {
            println!("{:<16} {count} flagged: {reason}", "");
        }
    }
    println!();
}
