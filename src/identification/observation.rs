//! What a reading holds of each error, to first order: the coefficients of the errors' values with
//! the slides where the reading was taken.
//!
//! ```text
//! laser, level, autocollimator   E_k + (ω × r)_k of the slide at the lever r, or the angle itself
//! straightedge                   the same, minus where it is reversed
//! cylinder                       e_X + h/R·e_Y of the tool at x = R  (− e_X of a probe there,
//! face                           e_Z of the tool at x                 + e_X of one at x = −R)
//! midline, slope                 −u_x, −b of the head
//! ```
//!
//! The neglected terms are products of two angles times a lever (5 nm at 50 µrad and 2 m).

use nalgebra::Vector3;

use super::instrument::Quantity;
use super::reading::{Reading, Setup};
use super::reading_set::{ReadWhere, ReadingSet};
use crate::machine::conditions::Direction;
use crate::machine::error_name::Component;
use crate::machine::{Axis, ErrorName, MachineSettings, Pose, Station, first_order};

/// A term of a reading: the coefficient of an error with its slide at a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Term {
    /// The error.
    pub error: ErrorName,
    /// Where its slide stands, mm.
    pub position_mm: f64,
    /// From which side it came there.
    pub direction: Direction,
    /// Coefficient, of the reading's unit by the error's.
    pub factor: f64,
}

/// A station with what of its pose counts.
struct Part<'a> {
    station: Station,
    of: &'a dyn Fn(&Pose) -> f64,
    sign: f64,
}

/// The terms of a reading; those of the errors `sought` alone.
pub(crate) fn terms(
    machine: &MachineSettings,
    set: &ReadingSet,
    reading: &Reading,
    sought: &[ErrorName],
) -> Vec<Term> {
    if let Quantity::Error(name) = reading.quantity {
        return direct(set, reading, name, sought);
    }
    let radius = set.radius_mm.unwrap_or(0.0);
    let tip = if radius > 0.0 { machine.tip_above_axis_mm / radius } else { 0.0 };
    let cut_radius = move |pose: &Pose| pose.shift_mm.x + tip * pose.shift_mm.y;
    let along_x = |pose: &Pose| pose.shift_mm.x;
    let along_z = |pose: &Pose| pose.shift_mm.z;
    let slope = |pose: &Pose| pose.turn_rad.y;
    let (p, read) = (reading.position_mm, set.read.unwrap_or_default());
    let face_z = set.face_z_mm.unwrap_or(0.0);
    let probe = |x: f64, z: f64| probe_station(machine, set, x, z);
    let part = |station: Station, of, sign: f64| Part { station, of, sign };
    let parts: Vec<Part<'_>> = match (reading.quantity, read) {
        (Quantity::Radius, ReadWhere::Elsewhere) => vec![part(machine.tool(radius, p), &cut_radius, 1.0)],
        (Quantity::Radius, ReadWhere::SameSide) => {
            vec![part(machine.tool(radius, p), &cut_radius, 1.0), part(probe(radius, p), &along_x, -1.0)]
        }
        (Quantity::Radius, ReadWhere::OppositeSide) => {
            vec![part(machine.tool(radius, p), &cut_radius, 1.0), part(probe(-radius, p), &along_x, 1.0)]
        }
        (Quantity::Height, ReadWhere::Elsewhere) => vec![part(machine.tool(p, face_z), &along_z, 1.0)],
        (Quantity::Height, ReadWhere::SameSide) => {
            vec![part(machine.tool(p, face_z), &along_z, 1.0), part(probe(p, face_z), &along_z, -1.0)]
        }
        (Quantity::Height, ReadWhere::OppositeSide) => {
            vec![part(machine.tool(p, face_z), &along_z, 1.0), part(probe(-p, face_z), &along_z, -1.0)]
        }
        (Quantity::Midline, _) => vec![part(head_station(machine, p), &along_x, -1.0)],
        _ => vec![part(head_station(machine, p), &slope, -1.0)],
    };
    let of_part = |part: &Part<'_>| of_station(machine, reading.direction, part, sought);
    parts.iter().flat_map(of_part).collect()
}

/// The terms of the tool's error along a direction (0, 1, 2: X, Y, Z) with the slides at [x, z],
/// mm.
pub(crate) fn tool_terms(
    machine: &MachineSettings,
    [x_mm, z_mm]: [f64; 2],
    along: usize,
    direction: Direction,
    sought: &[ErrorName],
) -> Vec<Term> {
    let of = move |pose: &Pose| pose.shift_mm[along];
    let part = Part { station: machine.tool(x_mm, z_mm), of: &of, sign: 1.0 };
    of_station(machine, direction, &part, sought)
}

/// The head where it sees a place of the part.
fn head_station(machine: &MachineSettings, z_mm: f64) -> Station {
    machine.head(z_mm - machine.head_beside_tool_mm())
}

/// A probe whose tip stands at a place: its levers are its own. It measures where the tool would
/// stand with the slides there, so that it is the slides' levers that differ.
fn probe_station(machine: &MachineSettings, set: &ReadingSet, x_mm: f64, z_mm: f64) -> Station {
    let tool = machine.tool(x_mm, z_mm);
    let Some(probe_mm) = set.probe_mm else { return tool };
    let beside = Vector3::from(probe_mm) - Vector3::from(machine.tool_mm);
    let slide = machine.tool(x_mm - beside.x, z_mm - beside.z);
    let at_z = match machine.chain {
        crate::machine::topology::Topology::TShaped => slide.z_lever_mm,
        crate::machine::topology::Topology::Carriage => slide.z_lever_mm + beside,
    };
    Station { point_mm: tool.point_mm, x_lever_mm: Some(Vector3::from(probe_mm)), z_lever_mm: at_z, ..slide }
}

fn of_station(
    machine: &MachineSettings,
    direction: Direction,
    part: &Part<'_>,
    sought: &[ErrorName],
) -> Vec<Term> {
    let term = |error: &ErrorName| {
        let pose = first_order::contribution(machine.chain, &part.station, *error);
        let position_mm = if error.axis() == Axis::X { part.station.x_mm } else { part.station.z_mm };
        Term { error: *error, position_mm, direction, factor: part.sign * (part.of)(&pose) }
    };
    sought.iter().map(term).filter(|term| term.factor != 0.0).collect()
}

/// Readings of a slide itself, whose directions are the machine's.
fn direct(set: &ReadingSet, reading: &Reading, name: ErrorName, sought: &[ErrorName]) -> Vec<Term> {
    let sign = if reading.setup == Setup::Reversed { -1.0 } else { 1.0 };
    let lever = Vector3::from(set.line_mm.unwrap_or_default());
    let factor = |error: &ErrorName| match (name.component(), error.component()) {
        _ if error.axis() != name.axis() => 0.0,
        (Component::Along(k), Component::About(turn)) => Vector3::ith(turn, 1.0).cross(&lever)[k],
        _ if *error == name => 1.0,
        _ => 0.0,
    };
    let term = |error: &ErrorName| Term {
        error: *error,
        position_mm: reading.position_mm,
        direction: reading.direction,
        factor: sign * factor(error),
    };
    sought.iter().map(term).filter(|term| term.factor != 0.0).collect()
}
