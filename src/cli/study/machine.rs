//! `shadowgauge study machine`: the errors of a lathe over its working space, their budget, and
//! what a probe and heads make of them.

use std::path::{Path, PathBuf};

use super::machine_models;
use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::{ConfigText, StudyFolder, csv_text, json_text, say_study};
use crate::config::machine_tables::read_error_tables;
use crate::report::{MachinePage, machine_page};
use crate::studies::machine::{
    Budget, Comparison, Extent, MachineStudy, MachineStudyConfig, MachineStudyError, MapPoint, ModelsAsked,
    Speed,
};

/// Arguments of `study machine`.
#[derive(Debug, clap::Args)]
pub(crate) struct StudyMachineArgs {
    /// A machine with its errors, as configs/machine_001.toml.
    config: PathBuf,
    /// A position of both slides, mm (X is radial): prints the errors there alone. May be repeated.
    #[arg(long, value_name = "X,Z", value_parser = position, allow_hyphen_values = true)]
    at: Vec<[f64; 2]>,
    /// Compares models of the errors instead: the paper's nets, splines, polynomials and the errors
    /// through the chain, by their error between the samples.
    #[arg(long, conflicts_with_all = ["at", "out"])]
    models: bool,
    /// Times the errors over the map instead, all of them as tables, N rounds on one thread.
    #[arg(long, value_name = "N", conflicts_with_all = ["at", "out", "models"])]
    bench: Option<u32>,
    /// Standard deviation of a sample of the models, µm.
    #[arg(long, value_name = "UM", default_value_t = 0.01, requires = "models")]
    noise_um: f64,
    /// Positions of either slide at which the models are given samples.
    #[arg(long, value_name = "N", default_value_t = 51, requires = "models")]
    positions: usize,
    /// Hidden units of the net of two inputs.
    #[arg(long, value_name = "N", default_value_t = 20, requires = "models")]
    hidden: usize,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write map.csv, budget.csv, heads.csv, readings.csv, form.csv, aliases.csv, their charts and
    /// report.html into this folder.
    #[arg(long, value_name = "DIR", conflicts_with = "at")]
    out: Option<PathBuf>,
}

/// A point of the map as a row of `map.csv`.
#[derive(serde::Serialize)]
struct MapRow {
    x_mm: f64,
    z_mm: f64,
    e_x_um: f64,
    e_y_um: f64,
    e_z_um: f64,
    first_order_x_um: f64,
    first_order_y_um: f64,
    first_order_z_um: f64,
}

/// What one error does to the cut and to a head as a row of `heads.csv`.
#[derive(serde::Serialize)]
struct HeadRow<'a> {
    error: &'a str,
    size: &'a str,
    by: &'a str,
    diameter_nm: f64,
}

/// A reading as a row of `readings.csv`.
#[derive(serde::Serialize)]
struct ReadingRow<'a> {
    by: &'a str,
    z_mm: f64,
    cut_um: f64,
    own_um: f64,
    indicated_um: f64,
    midline_um: Option<f64>,
}

/// Reads `X,Z`.
fn position(text: &str) -> Result<[f64; 2], String> {
    let numbers: Vec<Option<f64>> =
        text.split(',').map(|n| n.trim().parse().ok().filter(|v: &f64| v.is_finite())).collect();
    match numbers[..] {
        [Some(x), Some(z)] => Ok([x, z]),
        _ => Err("two numbers with a comma between them, X,Z in mm: 50,20".to_owned()),
    }
}

/// Runs the study.
///
/// # Errors
/// Exit 2 for a config, a table or a position that is refused, 3 for a disk that fails.
pub(crate) fn run(args: &StudyMachineArgs) -> CommandResult {
    let text = ConfigText::read(&args.config)?;
    let mut config: MachineStudyConfig = text.parse()?;
    let folder = args.config.parent().unwrap_or(Path::new(""));
    read_error_tables(&mut config.machine, folder).map_err(|e| text.refuse_at(e))?;
    if !args.at.is_empty() {
        let points = config.at(&args.at).map_err(|e| refuse(&text, e))?;
        return say_points(&points, args.json);
    }
    if let Some(rounds) = args.bench {
        let speed = config.speed(rounds).map_err(|e| refuse(&text, e))?;
        return say_study(&speed, args.json, print_speed);
    }
    if args.models {
        let StudyMachineArgs { noise_um, positions, hidden, .. } = *args;
        let asked = ModelsAsked { noise_um, positions, hidden, ..ModelsAsked::default() };
        let models = config.models(&asked).map_err(|e| refuse(&text, e))?;
        return say_study(&models, args.json, machine_models::print);
    }
    let study = config.run().map_err(|e| match e {
        MachineStudyError::Setting(e) => text.refuse_at(e),
        e => text.refuse(e),
    })?;
    StudyFolder::fill(StudyFolder::claim(args.out.as_deref())?, |folder| write(folder, &study))?;
    say_study(&study, args.json, print)
}

/// A refusal of the command line, or of the config at its place.
fn refuse(text: &ConfigText, error: crate::setting::SettingError) -> Failure {
    if error.key.starts_with("--") { Failure::refuse(error) } else { text.refuse_at(error) }
}

fn say_points(points: &[MapPoint], json: bool) -> CommandResult {
    if json {
        say_line!("{}", json_text(&serde_json::json!({ "points": points }))?);
        return Ok(Outcome::Done);
    }
    say_line!("tool relative to part, µm; beside it the first order");
    say_line!("{:>9} {:>9} {:>20} {:>20} {:>20}", "X / mm", "Z / mm", "along X", "along Y", "along Z");
    for p in points {
        let pair = |exact: f64, linear: f64| format!("{exact:10.4} {linear:9.4}");
        let f = p.first_order;
        say_line!(
            "{:9.3} {:9.3} {} {} {}",
            p.x_mm,
            p.z_mm,
            pair(p.e_x_um, f.e_x_um),
            pair(p.e_y_um, f.e_y_um),
            pair(p.e_z_um, f.e_z_um)
        );
    }
    Ok(Outcome::Done)
}

fn print_speed(speed: &Speed) {
    say_line!(
        "e(x, z) by the exact chain from tables, one thread: {:.2} million points a second, median {:.2} ({} rounds of {} points)",
        1e-6 * speed.points_per_s_max,
        1e-6 * speed.points_per_s_median,
        speed.rounds,
        speed.points
    );
}

fn print(study: &MachineStudy) {
    say_line!(
        "{}: {} by {} points; tool relative to part, µm",
        study.chain,
        study.map.x_points,
        study.map.z_points
    );
    let row = |name: &str, e: &Extent| {
        say_line!(
            "along {name}  {:9.3} to {:9.3}, peak to valley {:8.3}; no f(x) + g(z) holds {:.4} rms",
            e.min_um,
            e.max_um,
            e.range_um,
            e.not_separable_um
        );
    };
    row("X", &study.map.e_x);
    row("Y", &study.map.e_y);
    row("Z", &study.map.e_z);
    say_line!("the first order is off by {:.4} nm at most", study.map.first_order_off_nm);
    print_budget(&study.budget);
    print_heads(&study.heads);
    print_form(study);
}

fn print_form(study: &MachineStudy) {
    say_line!("\nform of the part, µm: as it is, and as a probe on the machine indicates it");
    say_line!(
        "{:<34} {:>7} {:>13} {:>12} {:>11} {:>9}",
        "",
        "points",
        "least squares",
        "minimum zone",
        "tool's side",
        "opposite"
    );
    for r in &study.form {
        let opposite = r.opposite_um.map_or_else(|| "-".to_owned(), |um| format!("{um:.4}"));
        say_line!(
            "{:<34} {:>7} {:13.4} {:12.4} {:11.4} {opposite:>9}",
            r.form,
            r.points,
            r.least_squares_um,
            r.minimum_zone_um,
            r.probe_um
        );
    }
    let hidden =
        study.aliases.iter().filter(|a| a.is_hidden()).map(|a| a.order.to_string()).collect::<Vec<_>>();
    for r in &study.separation {
        let (motion, form) = (r.motion_off_um, r.form_off_um);
        say_line!(
            "separating spindle and form, {:<26} {:>2} turns: motion off by {motion:.4}, form by {form:.4} rms, noise times {:.2}",
            r.method,
            r.turns,
            r.noise
        );
    }
    if !hidden.is_empty() {
        say_line!("the spiral on the face shows less than half of faces with {} lobes", hidden.join(", "));
    }
}

fn print_budget(budget: &Budget) {
    say_line!("\nbudget: each error alone, peak to valley, µm (its own size µm or µrad)");
    let head = ["size", "drift", "along X", "along Y", "along Z", "diameter"];
    say_line!("{:<5} {}", "", head.map(|h| format!("{h:>9}")).join(" "));
    for r in budget.rows.iter().filter(|r| r.size != 0.0 || r.drift != 0.0) {
        let cells = [r.size, r.drift, r.e_x_um, r.e_y_um, r.e_z_um, r.cut_um];
        say_line!("{:<5} {}  {}", r.error, cells.map(|v| format!("{v:9.3}")).join(" "), r.meaning);
    }
    let sums = [
        ("together", &budget.together),
        ("root sum square", &budget.root_sum_square),
        ("worst", &budget.worst),
    ];
    for (name, sum) in sums {
        say_line!("{name:<25} {:9.3} {:9.3} {:9.3}", sum.e_x_um, sum.e_y_um, sum.e_z_um);
    }
}

fn print_heads(heads: &Comparison) {
    say_line!("\none error alone in the diameter, nm: cut, read by a probe on the tool's slide, by heads");
    let names = heads.heads.iter().map(|name| format!("{name:>14.14}")).collect::<Vec<_>>().join(" ");
    say_line!("{:<5} {:>7} {:>11} {:>11} {names} {:>11}", "", "size", "cut", "probe", "midline");
    for s in &heads.sensitivities {
        let by_heads = s.heads_nm.iter().map(|v| format!("{:14.4}", tidy(*v))).collect::<Vec<_>>().join(" ");
        say_line!(
            "{:<5} {:>7} {:11.3} {:11.3} {by_heads} {:11.3}",
            s.error,
            s.size,
            tidy(s.cut_nm),
            tidy(s.probe_nm),
            tidy(s.midline_nm)
        );
    }
    say_line!("\nthe part that this machine turned, as it is read on it; µm of diameter");
    say_line!("{:<24} {:>9} {:>10} {:>14}", "", "cut P-V", "indicated", "rms of error");
    for r in &heads.readings {
        say_line!(
            "{:<24} {:9.3} {:10.3} {:14.4}",
            r.name,
            r.cut_range_um,
            r.indicated_range_um,
            r.rms_off_um
        );
    }
}

/// Without the sign of a zero and what rounding leaves of one.
fn tidy(value: f64) -> f64 {
    if value.abs() < 5e-5 { 0.0 } else { value }
}

fn map_rows(study: &MachineStudy) -> Vec<MapRow> {
    let row = |p: &MapPoint| MapRow {
        x_mm: p.x_mm,
        z_mm: p.z_mm,
        e_x_um: p.e_x_um,
        e_y_um: p.e_y_um,
        e_z_um: p.e_z_um,
        first_order_x_um: p.first_order.e_x_um,
        first_order_y_um: p.first_order.e_y_um,
        first_order_z_um: p.first_order.e_z_um,
    };
    study.points.iter().map(row).collect()
}

fn head_rows(heads: &Comparison) -> Vec<HeadRow<'_>> {
    let mut rows = Vec::new();
    for s in &heads.sensitivities {
        let fixed = [("cut", s.cut_nm), ("probe", s.probe_nm), ("midline", s.midline_nm)];
        let of_heads = heads.heads.iter().map(String::as_str).zip(s.heads_nm.iter().copied());
        let all = fixed.into_iter().chain(of_heads);
        rows.extend(all.map(|(by, diameter_nm)| HeadRow { error: &s.error, size: s.size, by, diameter_nm }));
    }
    rows
}

fn reading_rows(heads: &Comparison) -> Vec<ReadingRow<'_>> {
    let rows = heads.readings.iter().flat_map(|reading| {
        reading.points.iter().map(|p| ReadingRow {
            by: &reading.name,
            z_mm: p.z_mm,
            cut_um: p.cut_um,
            own_um: p.own_um,
            indicated_um: p.indicated_um,
            midline_um: p.midline_um,
        })
    });
    rows.collect()
}

fn write(folder: &StudyFolder, study: &MachineStudy) -> Result<(), Failure> {
    let MachinePage { html, charts } = machine_page(study).map_err(Failure::fail)?;
    folder.write("map.csv", &csv_text(&map_rows(study))?)?;
    folder.write("budget.csv", &csv_text(&study.budget.rows)?)?;
    folder.write("heads.csv", &csv_text(&head_rows(&study.heads))?)?;
    folder.write("form.csv", &csv_text(&study.form)?)?;
    folder.write("aliases.csv", &csv_text(&study.aliases)?)?;
    folder.write("readings.csv", &csv_text(&reading_rows(&study.heads))?)?;
    charts.iter().try_for_each(|(name, svg)| folder.write(name, svg.as_bytes()))?;
    folder.write("report.html", html.as_bytes())
}
