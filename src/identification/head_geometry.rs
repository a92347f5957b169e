//! Where a machine of known errors carries its head, over z: what readings are corrected by.
//!
//! The pose is that of the exact chain with the static errors (20 °C, nothing warmed up), Z as the
//! fields of a scan are reached, upwards. Its uncertainty is the root of the sum of squares of each
//! error's own u by its lever (first order): errors that one set of readings holds together are
//! correlated, which is left out. Errors that count as zero have no uncertainty; they are named by
//! [`unread`].

use super::identified::{IdentifiedError, IdentifiedMachine};
use crate::gauge::calibration::{HeadGeometry, HeadPlace};
use crate::machine::conditions::Direction;
use crate::machine::{Axis, Chain, Conditions, ErrorName, MachineSettings, Station, first_order};
use crate::setting::SettingError;

/// Places over the travel: errors of slides have no wavelengths below some of their steps.
const PLACES: usize = 201;
/// Expansion of cast iron and steel, µm/(m·K): what the levers of a machine grow by.
const EXPANSION_UM_PER_M_K: f64 = 11.5;
/// Difference of temperature that is not stated, K: half of what a good shop keeps.
const SAME_K: f64 = 0.25;

/// The geometry of a machine whose errors count as known.
///
/// # Errors
/// Errors that cannot be right.
pub(crate) fn of_machine(machine: &MachineSettings) -> Result<HeadGeometry, SettingError> {
    geometry(machine, &|_| 0.0)
}

/// The geometry of an identified machine, with its uncertainty.
///
/// # Errors
/// As [`of_machine`].
pub(crate) fn of_identified(found: &IdentifiedMachine) -> Result<HeadGeometry, SettingError> {
    let machine = &found.machine;
    let u_mm = |station: &Station| {
        let part = |error: &IdentifiedError| {
            let name = ErrorName::ALL.into_iter().find(|name| name.code() == error.error);
            name.map_or(0.0, |name| {
                let by = first_order::contribution(machine.chain, station, name).shift_mm.y;
                let unit = if name.is_length() { 1e-3 } else { 1e-6 };
                by * unit * u_at(error, own_position(name, station))
            })
        };
        found.errors.iter().map(|error| part(error).powi(2)).sum::<f64>().sqrt()
    };
    geometry(machine, &u_mm)
}

fn geometry(machine: &MachineSettings, u_mm: &dyn Fn(&Station) -> f64) -> Result<HeadGeometry, SettingError> {
    let motion = machine.motion()?;
    let state = Conditions { x_direction: Direction::Backward, ..Conditions::default() };
    let [from, to] = machine.z_travel_mm;
    let place = |k: usize| {
        let z_mm = from + (to - from) * k as f64 / (PLACES - 1) as f64;
        let station = machine.head(z_mm);
        let values = motion.values(station.x_mm, station.z_mm, &state);
        let shift = Chain { topology: machine.chain, values }.pose(&station).shift_mm;
        HeadPlace {
            z_mm: station.point_mm.z,
            axis_y_mm: -shift.y,
            u_axis_y_mm: u_mm(&station),
            axial_mm: shift.z,
        }
    };
    HeadGeometry::new((0..PLACES).map(place).collect())
}

/// The position of an error's own slide; 0 of the spindle's.
fn own_position(name: ErrorName, station: &Station) -> f64 {
    match name.axis() {
        Axis::X => station.x_mm,
        Axis::Z => station.z_mm,
        Axis::C => 0.0,
    }
}

/// The standard uncertainty of an error at a position, in its unit: linear between the positions of
/// its table; that of an orientation.
fn u_at(error: &IdentifiedError, position_mm: f64) -> f64 {
    let (positions, u) = (&error.position_mm, &error.u);
    let after = positions.partition_point(|p| *p <= position_mm);
    match (after.checked_sub(1), positions.get(after), u.get(after)) {
        (Some(k), Some(next), Some(u_next)) => {
            let share = (position_mm - positions[k]) / (next - positions[k]);
            u[k] + share * (u_next - u[k])
        }
        (Some(k), ..) => u.get(k).copied().unwrap_or(0.0),
        (None, ..) => u.first().copied().unwrap_or(0.0),
    }
}

/// Errors that move the head along Y and count as zero in a file, by their names: what they add is
/// neither in û_y nor in its uncertainty.
pub(crate) fn unread(found: &IdentifiedMachine) -> Vec<String> {
    let station = found.machine.head(found.machine.z_travel_mm[1]);
    let moves = |code: &&String| {
        let name = ErrorName::ALL.into_iter().find(|name| name.code() == **code);
        name.is_some_and(|name| {
            first_order::contribution(found.machine.chain, &station, name).shift_mm.y != 0.0
        })
    };
    found.taken_as_zero.iter().filter(moves).cloned().collect()
}

/// What a machine at another temperature than that of its readings amounts to, in words; none where
/// both are the same within a quarter of a kelvin.
///
/// The figure is the growth of the machine's longest lever, as of cast iron or steel: no table of
/// errors holds it, and how much of it reaches the tool is the machine's own affair (ISO 230-3).
pub(crate) fn temperature_consequence(
    machine: &MachineSettings,
    identified_c: f64,
    temperature_c: f64,
) -> Option<String> {
    let warmer_k = temperature_c - identified_c;
    if warmer_k.abs() <= SAME_K {
        return None;
    }
    let length = |lever: [f64; 3]| lever.iter().map(|v| v * v).sum::<f64>().sqrt();
    let longest_mm =
        [machine.tool_mm, machine.head_mm, machine.carriage_mm].into_iter().map(length).fold(0.0, f64::max);
    let growth_um = 1e-3 * EXPANSION_UM_PER_M_K * longest_mm * warmer_k.abs();
    Some(format!(
        "the machine is at {temperature_c} °C, its errors were read at {identified_c} °C: over {:.1} K a lever of {longest_mm:.0} mm of \
         cast iron or steel grows by {growth_um:.1} µm, which is in no table; along X that is up to {:.1} µm of a diameter that is cut, \
         along Y it moves the head by as much. Identify again at this temperature, or let the machine settle",
        warmer_k.abs(),
        2.0 * growth_um
    ))
}
