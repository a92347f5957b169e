//! `shadowgauge calibrate machine`: the errors of a machine from readings.

use std::path::{Path, PathBuf};

use super::machine_tables::{Tables, write_tables};
use super::machine_words::print;
use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::{ConfigText, StudyFolder, json_text};
use crate::config::read_machine_file;
use crate::files::OutputFile;
use crate::identification::spindle_readings::{SpindleRow, SpindleSet};
use crate::identification::{
    CheckedSet, Identification, IdentificationConfig, checked_set, identify, spindle,
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
    /// Write errors.csv, compensation.csv, positioning.csv, screw tables of LinuxCNC and a
    /// program's knots into this folder, and the simulated readings where there are any.
    #[arg(long, value_name = "DIR")]
    tables: Option<PathBuf>,
    /// Radius of the cylinder whose knots are written, mm; that of the first turned cylinder
    /// without it.
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
    if !(args.chord_um.is_finite() && args.chord_um > 0.0) {
        return Err(Failure::refuse(format!("--chord-um {}: must be above 0 µm", args.chord_um)));
    }
    let folder = args.config.parent().unwrap_or(Path::new(""));
    let read = read_sets(&config, folder).map_err(refuse)?;
    let file = OutputFile::claim(&args.out, [args.config.clone()])?;
    let tables = StudyFolder::claim(args.tables.as_deref())?;
    let sets: Vec<CheckedSet> = read.iter().map(|set| set.checked.clone()).collect();
    let mut found = identify(&config, &sets).map_err(refuse)?;
    for (k, set) in config.spindle.iter().enumerate() {
        let row = read_spindle(set, k, folder).map_err(refuse)?;
        found.file = found.file.with_spindle(row).map_err(refuse)?;
    }
    let of = Tables {
        found: &found,
        radius_mm: radius(args, &config, &found)?,
        chord_mm: 1e-3 * args.chord_um,
        simulated: read.into_iter().map(|set| set.simulated).collect(),
    };
    StudyFolder::fill(tables, |folder| write_tables(folder, &of))?;
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

/// Reads turns of an artefact and separates the spindle's motion from its form.
fn read_spindle(set: &SpindleSet, k: usize, folder: &Path) -> Result<SpindleRow, SettingError> {
    let (key, path) = (format!("spindle[{k}]"), folder.join(&set.file));
    let shown = path.display().to_string();
    let file = std::fs::File::open(&path)
        .map_err(|e| SettingError::at(format!("{key}.file"), format!("{shown}: cannot be read: {e}")))?;
    spindle(set, file, &key, &shown)
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
