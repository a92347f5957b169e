//! From readings to `machine.json`.

use super::equations::CheckedSet;
use super::identified::{
    FORMAT, IdentifiedError, IdentifiedMachine, IdentifiedRange, IdentifiedRank, ModelRow, PositioningRow,
    SetRow, UnknownRow,
};
use super::instrument::{Instrument, Quantity, is_straightness};
use super::iso230_2::positioning;
use super::reading::Reading;
use super::reading_set::{Datum, ReadWhere, ReadingSet};
use super::settings::{IdentificationConfig, ModelChoice};
use super::solution::{Solution, set_name, splines, structured};
use super::unknowns::{Group, SoughtError};
use crate::machine::conditions::Direction;
use crate::machine::table_file::Columns;
use crate::machine::{Axis, ErrorName, MachineSettings};
use crate::setting::SettingError;

/// Positions of a table: a knot of the spline has ten at the most, and a cubic across a tenth of a
/// knot leaves its line by a thousandth.
const TABLE_POSITIONS: usize = 241;

/// How much less the held-out error of a sum of splines must be for it to be taken: the chain holds
/// beyond the places that were read, and an rms of a hundred readings scatters by 7 %.
const CLEARLY_LESS: f64 = 0.9;

/// An identification: the file, and both models.
#[derive(Clone, Debug)]
pub(crate) struct Identification {
    /// `machine.json`.
    pub file: IdentifiedMachine,
    /// The model that it holds.
    pub chosen: Solution,
}

/// Identifies the errors of a machine from checked sets of readings.
///
/// # Errors
/// A value of the config, readings that do not hold what is sought, a range that does not hold the
/// head.
pub(crate) fn identify(
    config: &IdentificationConfig,
    sets: &[CheckedSet],
) -> Result<Identification, SettingError> {
    let sought = config.check()?;
    let chain = structured(config, sets, &sought)?;
    let sums = splines(config, sets, &sought)?;
    let (chosen, models) = choose(config.model, chain, sums)?;
    let file = file(config, sets, &chosen, models)?;
    Ok(Identification { file, chosen })
}

/// The chain, unless a sum of splines predicts parts that took no part clearly better, or is asked
/// for. Positions left out of one part are no such test: along a single cylinder both models are
/// one function of z.
fn choose(
    choice: ModelChoice,
    chain: Solution,
    sums: Option<Solution>,
) -> Result<(Solution, Vec<ModelRow>), SettingError> {
    let off = |solution: &Solution| solution.estimate.held_out_mm;
    let is_sums = match (choice, &sums) {
        (ModelChoice::Structured, _) | (ModelChoice::HeldOut, None) => false,
        (ModelChoice::Splines, Some(_)) => true,
        (ModelChoice::Splines, None) => {
            let why = "splines need a turned cylinder or face, and readings of lengths for every one of exx, ezx, exz, ezz that identify lists";
            return Err(SettingError::at("model", why));
        }
        (ModelChoice::HeldOut, Some(sums)) => {
            off(sums).zip(off(&chain)).is_some_and(|(sums, chain)| sums < CLEARLY_LESS * chain)
        }
    };
    let row = |model: &str, solution: &Solution, is_chosen: bool| ModelRow {
        model: model.to_owned(),
        held_out_um: solution.estimate.held_out_mm.map(|mm| 1e3 * mm),
        held_out_by_u: solution.estimate.held_out_by_u,
        is_chosen,
    };
    let mut models = vec![row("structured", &chain, !is_sums)];
    models.extend(sums.iter().map(|sums| row("splines", sums, is_sums)));
    let chosen = if is_sums { sums.unwrap_or(chain) } else { chain };
    Ok((chosen, models))
}

fn file(
    config: &IdentificationConfig,
    sets: &[CheckedSet],
    chosen: &Solution,
    models: Vec<ModelRow>,
) -> Result<IdentifiedMachine, SettingError> {
    let range = IdentifiedRange {
        x_mm: chosen.range_mm(true).unwrap_or(config.machine.x_travel_mm),
        z_mm: chosen.range_mm(false).unwrap_or(config.machine.z_travel_mm),
    };
    let errors: Vec<IdentifiedError> =
        chosen.unknowns.errors.iter().map(|sought| error(chosen, sought, &range)).collect();
    let zero = ErrorName::ALL.into_iter().filter(|name| !chosen.errors.contains(name));
    let has_head = config.readings.iter().any(|set| set.instrument == Instrument::Midline);
    let words = |k: usize| set_name(config, k);
    Ok(IdentifiedMachine {
        format: FORMAT.to_owned(),
        name: config.name.clone(),
        head: config.head.clone().filter(|_| has_head),
        temperature_c: config.temperature_c,
        model: models.iter().find(|row| row.is_chosen).map_or_else(String::new, |row| row.model.clone()),
        machine: settings(&config.machine, &errors, &range)?,
        range,
        errors,
        taken_as_zero: zero.map(ErrorName::code).collect(),
        rank: IdentifiedRank {
            unknowns: chosen.rank.unknowns,
            rank: chosen.rank.rank,
            determined: chosen.rank.determined,
            inseparable: chosen
                .rank
                .together
                .iter()
                .filter(|found| found.holds_an_error())
                .map(|found| found.words(&words))
                .collect(),
        },
        models,
        birge_ratio: chosen.estimate.birge_ratio,
        sets: sets.iter().enumerate().map(|(k, set)| set_row(config, k, set, chosen)).collect(),
        positioning: sets.iter().enumerate().flat_map(|(k, set)| positionings(config, k, set)).collect(),
        spindle: Vec::new(),
        unknowns: unknown_rows(chosen),
        covariance: covariance(chosen),
    })
}

/// The geometry with the errors as tables over the range.
fn settings(
    machine: &MachineSettings,
    errors: &[IdentifiedError],
    range: &IdentifiedRange,
) -> Result<MachineSettings, SettingError> {
    let mut settings = machine.clone();
    (settings.x_travel_mm, settings.z_travel_mm) = (range.x_mm, range.z_mm);
    for found in errors {
        let Some(name) = ErrorName::ALL.into_iter().find(|name| name.code() == found.error) else { continue };
        let orientation = match name {
            ErrorName::B0x => Some(&mut settings.b0x_urad),
            ErrorName::A0c => Some(&mut settings.a0c_urad),
            ErrorName::B0c => Some(&mut settings.b0c_urad),
            _ => None,
        };
        if let Some(orientation) = orientation {
            *orientation = found.value.first().copied().unwrap_or(0.0);
            continue;
        }
        let columns = Columns {
            position: found.position_mm.clone(),
            forward: found.value.clone(),
            backward: found.backward.clone(),
        };
        settings.errors.all_mut()[name as usize].fill(columns);
    }
    settings.motion().map_err(|e| {
        SettingError::at("readings", format!("do not reach far enough for the machine to be used: {e}"))
    })?;
    Ok(settings)
}

fn error(solution: &Solution, sought: &SoughtError, range: &IdentifiedRange) -> IdentifiedError {
    let (name, scale) = (sought.error, scale(sought.error.is_length()));
    let [from, to] = if name.axis() == Axis::X { range.x_mm } else { range.z_mm };
    let step = (to - from) / (TABLE_POSITIONS - 1) as f64;
    let at = |k: usize| if k + 1 == TABLE_POSITIONS { to } else { from + step * k as f64 };
    let positions: Vec<f64> =
        if sought.basis.is_some() { (0..TABLE_POSITIONS).map(at).collect() } else { vec![0.0] };
    let of = |direction: Direction| positions.iter().map(move |p| solution.error(sought, *p, direction));
    let datum = match sought.basis {
        None => "to the motion of Z (B0X: to square)",
        Some(_) if is_straightness(name) && !sought.has_slope => {
            "a line through it: its slope is an orientation"
        }
        Some(_) if is_straightness(name) => "its mean over the range",
        Some(_) => "zero in the middle of a line through it",
    };
    IdentifiedError {
        error: name.code(),
        meaning: name.meaning(),
        unit: name.unit().to_owned(),
        datum: datum.to_owned(),
        position_mm: if sought.basis.is_some() { positions.clone() } else { Vec::new() },
        value: of(Direction::Forward).map(|v| scale * v.value).collect(),
        backward: match sought.reversal {
            Some(_) => of(Direction::Backward).map(|v| scale * v.value).collect(),
            None => Vec::new(),
        },
        u: of(Direction::Forward).map(|v| scale * v.u).collect(),
    }
}

/// From mm or rad to µm or µrad.
pub(crate) fn scale(is_length: bool) -> f64 {
    if is_length { 1e3 } else { 1e6 }
}

fn set_row(config: &IdentificationConfig, k: usize, checked: &CheckedSet, solution: &Solution) -> SetRow {
    SetRow {
        set: set_name(config, k),
        instrument: checked.set.instrument.name().to_owned(),
        datum: datum_words(&checked.set).to_owned(),
        readings: checked.readings.len(),
        residual_by_u: solution.residual_by_u.get(k).copied().flatten(),
    }
}

/// What a set's readings are referred to, in words.
fn datum_words(set: &ReadingSet) -> &'static str {
    match (set.instrument, set.read.unwrap_or_default()) {
        (Instrument::Midline, _) => "the axis of rotation, with the part's sag and tailstock",
        (Instrument::Straightedge, _) => "a straightedge, turned over",
        (Instrument::Cylinder | Instrument::Face, _) if set.datum == Some(Datum::Line) => {
            "a line through the readings"
        }
        (Instrument::Cylinder | Instrument::Face, ReadWhere::Elsewhere) => {
            "the part's axis, read on another machine"
        }
        (Instrument::Cylinder | Instrument::Face, _) => "the motion of a probe on this machine",
        (Instrument::Laser, _) => "the laser's beam",
        (Instrument::Level, _) => "gravity",
        (Instrument::Autocollimator, _) => "the autocollimator's beam",
    }
}

/// ISO 230-2 of every error that a set reads.
fn positionings(config: &IdentificationConfig, k: usize, checked: &CheckedSet) -> Vec<PositioningRow> {
    let mut names: Vec<ErrorName> = Vec::new();
    for reading in &checked.readings {
        if let Quantity::Error(name) = reading.quantity
            && !names.contains(&name)
        {
            names.push(name);
        }
    }
    let row = |name: &ErrorName| {
        let of = |r: &&Reading| r.quantity == Quantity::Error(*name);
        let own: Vec<Reading> = checked.readings.iter().filter(of).copied().collect();
        Some(PositioningRow {
            set: set_name(config, k),
            error: name.code(),
            unit: name.unit().to_owned(),
            parameters: positioning(&own, scale(name.is_length()))?,
        })
    };
    if checked.set.instrument == Instrument::Straightedge {
        return Vec::new();
    }
    names.iter().filter_map(row).collect()
}

/// Number of unknowns of errors: they stand first.
fn own_unknowns(solution: &Solution) -> usize {
    solution.unknowns.all.iter().filter(|unknown| unknown.group.error().is_some()).count()
}

fn unknown_scale(solution: &Solution, k: usize) -> f64 {
    let error = solution.unknowns.all[k].group.error();
    scale(error.is_none_or(ErrorName::is_length))
}

fn unknown_rows(solution: &Solution) -> Vec<UnknownRow> {
    let row = |k: usize| {
        let group = &solution.unknowns.all[k].group;
        let before = solution.unknowns.all[..k].iter().filter(|unknown| unknown.group == *group).count();
        let what = match group {
            Group::Slope(_) => "slope".to_owned(),
            Group::Shape(_) => format!("shape {before}"),
            Group::Reversal(_) => format!("reversal {before}"),
            _ => "orientation".to_owned(),
        };
        let (error, scale) = (group.error(), unknown_scale(solution, k));
        UnknownRow {
            name: format!("{} {what}", error.map_or_else(String::new, ErrorName::code)),
            unit: error.map_or("", ErrorName::unit).to_owned(),
            value: scale * solution.estimate.values[k],
            u: scale * solution.estimate.covariance[(k, k)].max(0.0).sqrt(),
        }
    };
    (0..own_unknowns(solution)).map(row).collect()
}

fn covariance(solution: &Solution) -> Vec<Vec<f64>> {
    let at = |i: usize, j: usize| {
        unknown_scale(solution, i) * unknown_scale(solution, j) * solution.estimate.covariance[(i, j)]
    };
    (0..own_unknowns(solution)).map(|i| (0..=i).map(|j| at(i, j)).collect()).collect()
}
