//! A set's text as checked readings.

use std::io::Read;

use super::equations::CheckedSet;
use super::instrument::Instrument;
use super::reading::{Reading, Setup};
use super::reading_file::read_readings;
use super::settings::IdentificationConfig;
use crate::machine::Axis;
use crate::setting::{SettingError, require};

/// Reads the set `k` of a config from the text of its file.
///
/// # Errors
/// As [`read_readings`]; an uncertainty or a lever that its readings need, positions outside the
/// travel, a straightedge that was read one way only.
pub(crate) fn checked_set(
    config: &IdentificationConfig,
    k: usize,
    from: impl Read,
    file: &str,
) -> Result<CheckedSet, SettingError> {
    let set = &config.readings[k];
    let key = |name: &str| format!("readings[{k}].{name}");
    let readings = read_readings(from, set.instrument, &key("file"), file)?;
    let has_length = readings.iter().any(|reading| reading.quantity.is_length());
    let has_angle = readings.iter().any(|reading| !reading.quantity.is_length());
    let missing = |name: &str, why: &str| Err(SettingError::at(key(name), format!("{file}: {why}")));
    if has_length && set.u_um.is_none() {
        return missing("u_um", "holds lengths: their standard uncertainty weighs them, µm");
    }
    if has_angle && set.u_urad.is_none() {
        return missing("u_urad", "holds angles: their standard uncertainty weighs them, µrad");
    }
    if set.instrument == Instrument::Laser && has_length && set.line_mm.is_none() {
        let why = "holds lengths: the levers from the slide's reference to the reflector are missing; angles act by them (5 µrad at 100 mm are 0.5 µm), none is assumed";
        return missing("line_mm", why);
    }
    if set.instrument == Instrument::Straightedge {
        let is_there = |setup: Setup| readings.iter().any(|reading| reading.setup == setup);
        if !is_there(Setup::Normal) || !is_there(Setup::Reversed) {
            let why = "a straightedge read one way only: its own shape stays in the readings; turn it over and read again (setup = reversed)";
            return missing("file", why);
        }
    }
    readings.iter().try_for_each(|reading| in_travel(config, &key("file"), file, reading))?;
    Ok(CheckedSet { set: set.clone(), readings })
}

fn in_travel(
    config: &IdentificationConfig,
    key: &str,
    file: &str,
    reading: &Reading,
) -> Result<(), SettingError> {
    let machine = &config.machine;
    let ([from, to], axis) = match reading.quantity.axis() {
        Axis::X => (machine.x_travel_mm, "x"),
        _ => (machine.z_travel_mm, "z"),
    };
    let is_head =
        matches!(reading.quantity, super::instrument::Quantity::Midline | super::instrument::Quantity::Slope);
    let at = reading.position_mm - if is_head { machine.head_beside_tool_mm() } else { 0.0 };
    let right = format!("{from} to {to} mm, the travel (machine.{axis}_travel_mm)");
    let found = format!("{file}: line {}: slide at {at} mm", reading.line);
    require((from..=to).contains(&at), key, found, &right)
}
