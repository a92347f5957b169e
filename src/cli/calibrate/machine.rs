//! `shadowgauge calibrate machine`: the errors of a machine from readings.

use std::path::{Path, PathBuf};

use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::{ConfigText, StudyFolder, csv_text, json_text};
use crate::config::read_machine_file;
use crate::files::OutputFile;
use crate::identification::export::{knot_program, knots, screw_table, tool_errors};
use crate::identification::{
    CheckedSet, Identification, IdentificationConfig, IdentifiedMachine, checked_set, identify,
};
use crate::setting::SettingError;
use crate::studies::machine_readings::SimulatedMachine;

/// Arguments of `calibrate machine`.
#[derive(Debug, clap::Args)]
pub(crate) struct CalibrateMachineArgs {
    /// The machine's geometry, the errors that are sought and the sets of readings, as
    /// configs/machine_identify.toml.
    config: PathBuf,
    /// Where the identified errors go.
    #[arg(long, value_name = "FILE.json")]
    out: PathBuf,
    /// Write errors.csv, compensation.csv, positioning.csv, screw tables of LinuxCNC and a program's
    /// knots into this folder, and the simulated readings where there are any.
    #[arg(long, value_name = "DIR")]
    tables: Option<PathBuf>,
    /// Radius of the cylinder whose knots are written, mm; that of the first turned cylinder without
    /// it.
    #[arg(long, value_name = "MM", requires = "tables")]
    radius_mm: Option<f64>,
    /// How far a straight line between two knots may leave the error, µm.
    #[arg(long, value_name = "UM", requires = "tables", default_value_t = 0.1)]
    chord_um: f64,
    /// Print machine.json.
    #[arg(long)]
    json: bool,
}

/// Identifies and writes. Exit 1 where a combination of errors could not be separated.
///
/// # Errors
/// Exit 2 for a config or readings that are refused; 3 for files that cannot be read or written.
pub(crate) fn run(args: &CalibrateMachineArgs) -> CommandResult {
    if args.out.extension().is_none_or(|e| e != "json") {
        return Err(Failure::refuse(format!("--out {}: must end in .json", args.out.display())));
    }
    let text = ConfigText::read(&args.config)?;
    let config: IdentificationConfig = text.parse()?;
    let refuse = |e: SettingError| text.refuse_at(e);
    config.check().map_err(refuse)?;
    let folder = args.config.parent().unwrap_or(Path::new(""));
    let read = read_sets(&config, folder).map_err(refuse)?;
    let file = OutputFile::claim(&args.out, [args.config.clone()])?;
    let tables = StudyFolder::claim(args.tables.as_deref())?;
    let sets: Vec<CheckedSet> = read.iter().map(|set| set.checked.clone()).collect();
    let found = identify(&config, &sets).map_err(refuse)?;
    let radius_mm = radius(args, &config, &found)?;
    StudyFolder::fill(tables, |folder| write_tables(folder, args, &found, radius_mm, &read))?;
    file.write((json_text(&found.file)? + "\n").as_bytes())?;
    if args.json {
        say_line!("{}", json_text(&found.file)?);
    } else {
        print(&found.file);
    }
    let is_whole = found.file.rank.inseparable.is_empty();
    if !is_whole {
        tracing::warn!(
            "{} holds combinations that these readings do not determine; their uncertainty is the class's (prior)",
            args.out.display()
        );
    }
    Ok(if is_whole { Outcome::Done } else { Outcome::OutOfTolerance })
}

/// A set that was read, with its text where it was simulated.
struct ReadSet {
    checked: CheckedSet,
    simulated: Option<String>,
}

/// Reads the files of all sets, or simulates what they would hold.
fn read_sets(config: &IdentificationConfig, folder: &Path) -> Result<Vec<ReadSet>, SettingError> {
    let simulated = simulated_machine(config, folder)?;
    let set = |k: usize| -> Result<ReadSet, SettingError> {
        let set = &config.readings[k];
        if let Some(name) = &set.file {
            let path = folder.join(name);
            let shown = path.display().to_string();
            let key = format!("readings[{k}].file");
            let file = std::fs::File::open(&path)
                .map_err(|e| SettingError::at(key, format!("{shown}: cannot be read: {e}")))?;
            return Ok(ReadSet { checked: checked_set(config, k, file, &shown)?, simulated: None });
        }
        let text = simulated.as_ref().map_or_else(|| Ok(String::new()), |machine| machine.text(set, k))?;
        let checked = checked_set(config, k, text.as_bytes(), "simulated readings")?;
        Ok(ReadSet { checked, simulated: Some(text) })
    };
    (0..config.readings.len()).map(set).collect()
}

fn simulated_machine(
    config: &IdentificationConfig,
    folder: &Path,
) -> Result<Option<SimulatedMachine>, SettingError> {
    let is_needed = config.readings.iter().any(|set| set.file.is_none());
    let Some(simulate) = config.simulate.as_ref().filter(|_| is_needed) else { return Ok(None) };
    let settings = read_machine_file("simulate.machine", &folder.join(&simulate.machine))?.machine;
    let bare = |m: &crate::machine::MachineSettings| (m.chain, m.tool_mm, m.head_mm, m.carriage_mm);
    if bare(&settings) != bare(&config.machine) {
        let why = format!(
            "{}: has another chain or other levers than [machine]: its readings would be of another machine",
            simulate.machine
        );
        return Err(SettingError::at("simulate.machine", why));
    }
    SimulatedMachine::new(settings, config.temperature_c, simulate.seed).map(Some)
}

/// The radius of the cylinder whose knots are written, mm.
fn radius(
    args: &CalibrateMachineArgs,
    config: &IdentificationConfig,
    found: &Identification,
) -> Result<Option<f64>, Failure> {
    let [from, to] = found.file.range.x_mm;
    let Some(radius) = args.radius_mm else {
        return Ok(config.readings.iter().find_map(|set| set.radius_mm));
    };
    if !(from.max(0.0)..=to).contains(&radius) {
        return Err(Failure::refuse(format!(
            "--radius-mm {radius}: must lie in {from} to {to} mm, over which the errors of X are identified: beyond it none is given"
        )));
    }
    Ok(Some(radius))
}

fn write_tables(
    folder: &StudyFolder,
    args: &CalibrateMachineArgs,
    found: &Identification,
    radius_mm: Option<f64>,
    read: &[ReadSet],
) -> Result<(), Failure> {
    let (file, solution) = (&found.file, &found.chosen);
    let machine = &file.machine;
    folder.write("errors.csv", &csv_text(&error_rows(file))?)?;
    folder.write("compensation.csv", &csv_text(&tool_errors(solution, machine))?)?;
    folder.write("positioning.csv", &csv_text(&positioning_rows(file))?)?;
    let [x_from, _] = machine.x_travel_mm;
    let [z_from, z_to] = machine.z_travel_mm;
    let x_at = radius_mm.unwrap_or(x_from.max(0.0));
    let z_at = 0.0_f64.clamp(z_from, z_to);
    folder.write("linuxcnc_x.comp", screw_table(solution, machine, true, z_at).as_bytes())?;
    folder.write("linuxcnc_z.comp", screw_table(solution, machine, false, x_at).as_bytes())?;
    if let Some(radius) = radius_mm {
        let knots = knots(solution, machine, radius, 1e-3 * args.chord_um);
        folder.write("knots.csv", &csv_text(&knots)?)?;
        folder.write("knots.ngc", knot_program(&knots, &file.name).as_bytes())?;
    }
    for (k, text) in read.iter().enumerate().filter_map(|(k, set)| Some((k, set.simulated.as_ref()?))) {
        folder.write(&format!("readings_{k}.csv"), text.as_bytes())?;
    }
    Ok(())
}

/// An error at a position as a row of `errors.csv`.
#[derive(serde::Serialize)]
struct ErrorRow<'a> {
    error: &'a str,
    position_mm: Option<f64>,
    value: f64,
    backward: Option<f64>,
    u: f64,
    unit: &'a str,
}

fn error_rows(file: &IdentifiedMachine) -> Vec<ErrorRow<'_>> {
    let rows = file.errors.iter().flat_map(|error| {
        (0..error.value.len()).map(move |k| ErrorRow {
            error: &error.error,
            position_mm: error.position_mm.get(k).copied(),
            value: error.value[k],
            backward: error.backward.get(k).copied(),
            u: error.u[k],
            unit: &error.unit,
        })
    });
    rows.collect()
}

/// A parameter of ISO 230-2 as a row of `positioning.csv`.
#[derive(serde::Serialize)]
struct ParameterRow<'a> {
    set: &'a str,
    error: &'a str,
    parameter: &'static str,
    value: f64,
    unit: &'a str,
}

fn positioning_rows(file: &IdentifiedMachine) -> Vec<ParameterRow<'_>> {
    let mut rows = Vec::new();
    for found in &file.positioning {
        let p = &found.parameters;
        let one = |names: [&'static str; 3], of: &Option<crate::identification::iso230_2::OneDirection>| {
            of.map_or_else(Vec::new, |d| names.into_iter().zip([d.a, d.r, d.e]).collect())
        };
        let mut all: Vec<(&'static str, f64)> = one(["A_forward", "R_forward", "E_forward"], &p.forward);
        all.extend(one(["A_backward", "R_backward", "E_backward"], &p.backward));
        let both = ["A", "R", "E", "M", "B", "B_mean"];
        if let Some(b) = &p.both {
            all.extend(both.into_iter().zip([b.a, b.r, b.e, b.m, b.b, b.b_mean]));
        }
        let (set, error, unit) = (found.set.as_str(), found.error.as_str(), found.unit.as_str());
        let row = |(parameter, value)| ParameterRow { set, error, parameter, value, unit };
        rows.extend(all.into_iter().map(row));
    }
    rows
}

fn print(file: &IdentifiedMachine) {
    let range = &file.range;
    say_line!(
        "{}: X {} to {} mm, Z {} to {} mm, {} °C; model {}",
        file.name,
        range.x_mm[0],
        range.x_mm[1],
        range.z_mm[0],
        range.z_mm[1],
        file.temperature_c,
        file.model
    );
    say_line!("{:<5} {:>10} {:>10} {:>10} {:<5} {}", "", "least", "largest", "largest u", "unit", "what");
    for error in &file.errors {
        let (low, high) = error
            .value
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
        let u = error.u.iter().copied().fold(0.0, f64::max);
        let (code, unit, meaning) = (&error.error, &error.unit, &error.meaning);
        say_line!("{code:<5} {low:10.3} {high:10.3} {u:10.3} {unit:<5} {meaning}");
    }
    print_models(file);
    for found in &file.positioning {
        print_positioning(found);
    }
    for words in &file.rank.inseparable {
        say_line!("not separated: {words}");
    }
}

fn print_models(file: &IdentifiedMachine) {
    for model in &file.models {
        let held = model.held_out_um.map_or_else(
            || "no part can be left out (two cylinders or two faces are needed)".to_owned(),
            |um| format!("{um:.4} µm rms on parts that took no part"),
        );
        let chosen = if model.is_chosen { ", written" } else { "" };
        say_line!(
            "model {:<10} {held}; {:.2} times u at positions that took no part{chosen}",
            model.model,
            model.held_out_by_u
        );
    }
    let rank = &file.rank;
    say_line!(
        "Birge ratio {:.3}; {} unknowns, {} of them determined by the readings (rank {})",
        file.birge_ratio,
        rank.unknowns,
        rank.determined,
        rank.rank
    );
    for set in &file.sets {
        let left = set.residual_by_u.map_or_else(
            || "not used by this model".to_owned(),
            |by_u| format!("residuals {by_u:.2} times u"),
        );
        say_line!("{:<24} {:>5} {:<15} to {}; {left}", set.set, set.readings, set.instrument, set.datum);
    }
}

fn print_positioning(found: &crate::identification::identified::PositioningRow) {
    let p = &found.parameters;
    if let Some(b) = p.both {
        say_line!(
            "ISO 230-2 {} {}: A {:.3}, R {:.3}, E {:.3}, M {:.3}, B {:.3} {} ({} positions, {} runs)",
            found.error,
            found.set,
            b.a,
            b.r,
            b.e,
            b.m,
            b.b,
            found.unit,
            p.positions,
            p.runs
        );
    }
    for (name, of) in [("forward", p.forward), ("backward", p.backward)] {
        if let Some(d) = of {
            say_line!(
                "ISO 230-2 {} {name}: A {:.3}, R {:.3}, E {:.3} {}",
                found.error,
                d.a,
                d.r,
                d.e,
                found.unit
            );
        }
    }
    for short in &p.short_of_standard {
        say_line!("  {short}");
    }
}
