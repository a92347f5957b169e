//! Readings from a table of text ([`crate::text_table`]):
//! `axis,position_mm,direction,run,error,value,unit`, with `angle_deg` (a midline's, averaged over
//! φ and φ + 180°) and `setup` (a straightedge's) where they apply.
//!
//! Rows stand in the order in which they were read: that of a run shows whether its positions are
//! those of one direction.

use std::io::Read;

use super::instrument::{Instrument, Quantity};
use super::reading::{Reading, Row, Setup};
use super::reading_order::check_order;
use super::turn_mean::turn_means;
use crate::machine::Axis;
use crate::machine::conditions::Direction;
use crate::setting::SettingError;
use crate::text_table::{self, Cells, Comments, TextTable};

/// Largest reading, µm or µrad; as for the errors of a machine.
const LARGEST: f64 = 1000.0;
/// Columns that every file has.
const COLUMNS: [&str; 7] = ["axis", "position_mm", "direction", "run", "error", "value", "unit"];

/// Reads the readings of an instrument; `key` and `file` name them in errors.
///
/// # Errors
/// A missing column, a cell that is none of what its column holds, a quantity that the instrument
/// does not read, a value in another unit, positions that are not those of one direction, angles of
/// a midline without their opposite.
pub(crate) fn read_readings(
    mut from: impl Read,
    instrument: Instrument,
    key: &str,
    file: &str,
) -> Result<Vec<Reading>, SettingError> {
    let refuse = |problem: String| SettingError::at(key, format!("{file}: {problem}"));
    let mut bytes = Vec::new();
    from.read_to_end(&mut bytes).map_err(|e| refuse(e.to_string()))?;
    let table = TextTable::parse(&bytes, &COLUMNS, Comments::Hash).map_err(|e| refuse(e.to_string()))?;
    table.require(&COLUMNS).map_err(refuse)?;
    let mut rows = Vec::new();
    for cells in table.rows() {
        let cells = cells.map_err(|e| refuse(e.to_string()))?;
        let row = row(&cells, instrument);
        rows.push(row.map_err(|why| refuse(format!("line {}: {why}", cells.line())))?);
    }
    if rows.is_empty() {
        return Err(refuse("has no readings below its header".to_owned()));
    }
    check_order(&rows).map_err(refuse)?;
    turn_means(&rows).map_err(refuse)
}

fn row(cells: &Cells<'_>, instrument: Instrument) -> Result<Row, String> {
    let cell = |name: &str| cells.text(name).unwrap_or_default();
    let word = cell("error");
    let quantity = Quantity::parse(word).filter(|quantity| instrument.can_read(*quantity));
    let quantity = quantity.ok_or_else(|| {
        format!("error '{word}' is not read by a {}: {}", instrument.name(), instrument.reads())
    })?;
    let axis = if quantity.axis() == Axis::X { "X" } else { "Z" };
    if !cell("axis").eq_ignore_ascii_case(axis) {
        return Err(format!("axis '{}' must be {axis}, over which {word} is read", cell("axis")));
    }
    let run = cell("run");
    let run =
        run.parse().ok().filter(|run| *run > 0).ok_or_else(|| format!("run '{run}' must be 1, 2, …"))?;
    Ok(Row {
        reading: Reading {
            quantity,
            position_mm: number("position_mm", cell("position_mm"))?,
            direction: direction(cell("direction"))?,
            run,
            setup: setup(cell("setup"), instrument)?,
            value: value(cell("value"), cell("unit"), quantity)?,
            rows: 1,
            line: cells.line(),
        },
        angle_deg: Some(cell("angle_deg"))
            .filter(|text| !text.is_empty())
            .map(|text| number("angle_deg", text))
            .transpose()?,
    })
}

fn number(name: &str, text: &str) -> Result<f64, String> {
    text_table::number(text).ok_or_else(|| format!("{name} '{text}' must be a finite number"))
}

fn direction(text: &str) -> Result<Direction, String> {
    match text.to_ascii_lowercase().as_str() {
        "forward" | "+" => Ok(Direction::Forward),
        "backward" | "-" => Ok(Direction::Backward),
        _ => Err(format!("direction '{text}' must be forward or backward (+ or -)")),
    }
}

fn setup(text: &str, instrument: Instrument) -> Result<Setup, String> {
    match (text.to_ascii_lowercase().as_str(), instrument) {
        ("", Instrument::Straightedge) => {
            Err("setup is missing: normal, or reversed where the straightedge was turned over".to_owned())
        }
        ("" | "normal", _) => Ok(Setup::Normal),
        ("reversed", Instrument::Straightedge) => Ok(Setup::Reversed),
        _ => Err(format!("setup '{text}' must be normal, or reversed of a straightedge")),
    }
}

/// A value in mm or rad.
fn value(text: &str, unit: &str, quantity: Quantity) -> Result<f64, String> {
    let value = number("value", text)?;
    let scale = match (unit, quantity.is_length()) {
        ("nm", true) => 1e-6,
        ("um" | "µm", true) => 1e-3,
        ("mm", true) => 1.0,
        ("urad" | "µrad", false) => 1e-6,
        ("mrad", false) => 1e-3,
        ("arcsec", false) => (1.0_f64 / 3600.0).to_radians(),
        (_, true) => {
            return Err(format!("unit '{unit}' must be nm, um or mm: {} is a length", quantity.word()));
        }
        (_, false) => {
            return Err(format!(
                "unit '{unit}' must be urad, mrad or arcsec: {} is an angle",
                quantity.word()
            ));
        }
    };
    let (shown, smaller, per) =
        if quantity.is_length() { ("µm", "nm", 1e3) } else { ("µrad", "nrad", 1e6) };
    if (per * scale * value).abs() > LARGEST {
        return Err(format!(
            "value {text} {unit} is beyond ±{LARGEST} {shown}, a thousand times what a machine has: was it read in {smaller}, or is it the position instead of the deviation?"
        ));
    }
    Ok(scale * value)
}
