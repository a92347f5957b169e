//! `[[spindle]]`: error motion of the spindle from turns of an artefact, separated from its form.
//!
//! Readings of a turn are averaged over its turns: the synchronous error motion (ISO 230-7). The
//! separations are those of [`crate::machine::spindle`]; a step of the artefact is named by the
//! column `step`, from 0.

use std::io::Read;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::machine::spindle::{Separation, donaldson, multi_step, rechucked};
use crate::setting::{SettingError, positive, require};
use crate::text_table::{Comments, TextTable};

/// Largest reading, µm; as for the errors of a machine.
const LARGEST_UM: f64 = 1000.0;
/// How far an angle may lie from equal spacing, degrees: a run-out of 10 µm then changes by 2 nm.
const SPACING_DEG: f64 = 0.01;
/// Columns that every file has.
const COLUMNS: [&str; 3] = ["angle_deg", "step", "value_um"];

/// How motion and form are separated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum SpindleMethod {
    /// Donaldson's reversal: artefact turned half a turn, probe on the other side. Steps 0 and 1.
    Reversal,
    /// The artefact turned by 1/N of a turn each time, the probe left. Steps 0 to N − 1.
    MultiStep,
    /// The midline of a two-sided head, the part chucked again half a turn on. Steps 0 and 1.
    Rechucked,
}

/// Turns of an artefact on the spindle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SpindleSet {
    /// How motion and form are separated.
    pub method: SpindleMethod,
    /// A CSV file beside the config: angle_deg, step, value_um (towards +X), equally spaced angles.
    pub file: String,
    /// Standard uncertainty of a reading, µm. Must be above 0.
    pub u_um: f64,
}

/// Error motion of the spindle, separated; µm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SpindleRow {
    /// The file.
    pub set: String,
    /// reversal, multi_step or rechucked.
    pub method: SpindleMethod,
    /// Spindle angles, degrees.
    pub angle_deg: Vec<f64>,
    /// EXC: motion of the axis along X.
    pub motion_um: Vec<f64>,
    /// Its standard uncertainty.
    pub u_um: f64,
    /// Form of the artefact; of a two-sided head its odd part.
    pub form_um: Vec<f64>,
    /// What the method does not separate.
    pub not_separated: String,
}

/// Reads and separates a set; `key` and `shown` name it in errors.
///
/// # Errors
/// A missing column, values in another unit, angles that are not equally spaced over a turn or
/// differ between steps, steps that the method does not have.
pub(crate) fn spindle(
    set: &SpindleSet,
    from: impl Read,
    key: &str,
    shown: &str,
) -> Result<SpindleRow, SettingError> {
    positive(&format!("{key}.u_um"), set.u_um)?;
    let file = format!("{key}.file");
    let refuse = |problem: String| SettingError::at(&file, format!("{shown}: {problem}"));
    let turns = turns(from).map_err(refuse)?;
    let steps = turns.len();
    let right = match set.method {
        SpindleMethod::MultiStep => "2 or more steps (0, 1, 2 …)",
        _ => "two steps, 0 and 1: as it is, and reversed",
    };
    let fits = if set.method == SpindleMethod::MultiStep { steps >= 2 } else { steps == 2 };
    require(fits, &file, format!("{shown}: {steps} steps"), right)?;
    let angle_deg: Vec<f64> = turns[0].iter().map(|(angle, _)| *angle).collect();
    for (k, turn) in turns.iter().enumerate() {
        spacing(turn, &angle_deg).map_err(|why| refuse(format!("step {k}: {why}")))?;
    }
    let values: Vec<Vec<f64>> =
        turns.iter().map(|turn| turn.iter().map(|(_, value)| *value).collect()).collect();
    let separated = match set.method {
        SpindleMethod::Reversal => donaldson(&values[0], &values[1]),
        SpindleMethod::Rechucked => rechucked(&values[0], &values[1]),
        SpindleMethod::MultiStep => multi_step(&values),
    };
    let count = angle_deg.len();
    let why = format!("{count} angles a turn, which {steps} steps must divide");
    let Separation { form, motion } = separated.ok_or_else(|| refuse(why))?;
    let share = match set.method {
        SpindleMethod::MultiStep => steps as f64,
        _ => 2.0,
    };
    Ok(SpindleRow {
        set: shown.to_owned(),
        method: set.method,
        angle_deg,
        motion_um: motion,
        u_um: set.u_um / share.sqrt(),
        form_um: form,
        not_separated: not_separated(set.method, steps),
    })
}

fn not_separated(method: SpindleMethod, steps: usize) -> String {
    match method {
        SpindleMethod::Reversal => "nothing; the eccentricity is in the form".to_owned(),
        SpindleMethod::MultiStep => format!("lobes of {steps} a turn and its multiples stay in both"),
        SpindleMethod::Rechucked => "even lobes of the part are in neither".to_owned(),
    }
}

/// A turn: angles with their values, µm.
type Turn = Vec<(f64, f64)>;

/// The turns by their steps.
fn turns(mut from: impl Read) -> Result<Vec<Turn>, String> {
    let mut bytes = Vec::new();
    from.read_to_end(&mut bytes).map_err(|e| e.to_string())?;
    let table = TextTable::parse(&bytes, &COLUMNS, Comments::Hash).map_err(|e| e.to_string())?;
    table.require(&COLUMNS)?;
    let mut turns: Vec<Turn> = Vec::new();
    for cells in table.rows() {
        let cells = cells.map_err(|e| e.to_string())?;
        let (angle, value, line) = (cells.number("angle_deg")?, cells.number("value_um")?, cells.line());
        if value.abs() > LARGEST_UM {
            return Err(format!(
                "line {line}: value_um {value} is beyond ±{LARGEST_UM}, a thousand times what a spindle has: was it read in nm?"
            ));
        }
        let step = cells.text("step").unwrap_or_default();
        let step: usize = step
            .parse()
            .ok()
            .filter(|step| *step <= turns.len())
            .ok_or_else(|| format!("line {line}: step '{step}' must be 0, 1, 2 … turn after turn"))?;
        if step == turns.len() {
            turns.push(Vec::new());
        }
        turns[step].push((angle, value));
    }
    Ok(turns)
}

/// Refuses angles that are not equally spaced over one turn, or not those of the first step.
fn spacing(turn: &Turn, first_deg: &[f64]) -> Result<(), String> {
    let count = first_deg.len();
    if turn.len() != count || count < 4 {
        return Err(format!(
            "{} angles; every step has the same, at least 4 (step 0 has {count})",
            turn.len()
        ));
    }
    for (k, (angle, _)) in turn.iter().enumerate() {
        let wanted = first_deg[0] + 360.0 * k as f64 / count as f64;
        if (angle - wanted).abs() > SPACING_DEG {
            return Err(format!(
                "angle {angle} where {wanted} is due: {count} angles equally spaced over one turn, ascending"
            ));
        }
    }
    Ok(())
}
