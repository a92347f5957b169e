//! What each of the 21 errors does on its own, over the working space.

use serde::Serialize;

use super::map::{MapPoint, range};
use super::prepared::Prepared;
use crate::machine::response::{Part, cut_mm};
use crate::machine::{Axis, Conditions, ErrorName, ErrorValues, Station, first_order};

/// Spindle angles at which the errors of the spindle are evaluated.
const ANGLES: u32 = 72;

/// An error: its own size, and the peak to valley of what it does.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct BudgetRow {
    /// Name of ISO 230-1.
    pub error: String,
    /// What it is.
    pub meaning: String,
    /// Unit of its own size.
    pub unit: &'static str,
    /// Peak to valley of the error over its axis; of an orientation its value.
    pub size: f64,
    /// Largest drift in the state of the study, in the same unit.
    pub drift: f64,
    /// Peak to valley along X over the working space, µm.
    pub e_x_um: f64,
    /// Peak to valley along Y, µm.
    pub e_y_um: f64,
    /// Peak to valley along Z, µm.
    pub e_z_um: f64,
    /// Peak to valley in the diameter that is cut along the part, µm.
    pub cut_um: f64,
}

/// What all errors do together, µm peak to valley.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct BudgetSum {
    /// Along X.
    pub e_x_um: f64,
    /// Along Y.
    pub e_y_um: f64,
    /// Along Z.
    pub e_z_um: f64,
}

/// The budget of the machine's geometry.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Budget {
    /// The errors, in the order of their names.
    pub rows: Vec<BudgetRow>,
    /// Of the map: what these errors do together.
    pub together: BudgetSum,
    /// Sum of the rows: what they could do at worst.
    pub worst: BudgetSum,
    /// Root of the sum of squares: what they would do were they independent.
    pub root_sum_square: BudgetSum,
}

/// The budget of a machine and of the cylinder or cone that is turned on it.
pub(crate) fn budget(machine: &Prepared, part: &Part, map: &[MapPoint]) -> Budget {
    let rows: Vec<BudgetRow> = ErrorName::ALL.iter().map(|name| row(machine, part, *name)).collect();
    let span = |component: fn(&MapPoint) -> f64| {
        let (low, high) = range(map.iter().map(component));
        high - low
    };
    let sum = |component: fn(&BudgetRow) -> f64| rows.iter().map(component).sum::<f64>();
    let squares =
        |component: fn(&BudgetRow) -> f64| rows.iter().map(component).map(|v| v * v).sum::<f64>().sqrt();
    Budget {
        together: BudgetSum {
            e_x_um: span(|p| p.e_x_um),
            e_y_um: span(|p| p.e_y_um),
            e_z_um: span(|p| p.e_z_um),
        },
        worst: BudgetSum { e_x_um: sum(|r| r.e_x_um), e_y_um: sum(|r| r.e_y_um), e_z_um: sum(|r| r.e_z_um) },
        root_sum_square: BudgetSum {
            e_x_um: squares(|r| r.e_x_um),
            e_y_um: squares(|r| r.e_y_um),
            e_z_um: squares(|r| r.e_z_um),
        },
        rows,
    }
}

/// States of the machine at which an error is evaluated: all angles for the spindle's.
fn states(machine: &Prepared, name: ErrorName) -> Vec<Conditions> {
    if name.axis() != Axis::C || machine.motion.function(name).is_none() {
        return vec![machine.state];
    }
    let angle = |k: u32| 360.0 * f64::from(k) / f64::from(ANGLES);
    (0..ANGLES).map(|k| Conditions { c_deg: angle(k), ..machine.state }).collect()
}

/// Positions at which an error's effect is evaluated: of the spindle's, which is linear in x and in
/// z, the ends of the travels.
fn positions(machine: &Prepared, name: ErrorName) -> (Vec<f64>, Vec<f64>) {
    if name.axis() == Axis::C {
        return (machine.settings.x_travel_mm.to_vec(), machine.settings.z_travel_mm.to_vec());
    }
    (machine.x_mm.clone(), machine.z_mm.clone())
}

fn row(machine: &Prepared, part: &Part, name: ErrorName) -> BudgetRow {
    let mut shift = [(f64::INFINITY, f64::NEG_INFINITY); 3];
    let (x_mm, z_mm) = positions(machine, name);
    for state in states(machine, name) {
        for x in &x_mm {
            for z in &z_mm {
                let station = machine.settings.tool(*x, *z);
                let value = machine.motion.value(name, [*x, *z], &state);
                let one =
                    1e3 * value * first_order::contribution(machine.settings.chain, &station, name).shift_mm;
                for (extent, v) in shift.iter_mut().zip(one.iter()) {
                    *extent = (extent.0.min(*v), extent.1.max(*v));
                }
            }
        }
    }
    let [e_x_um, e_y_um, e_z_um] = shift.map(|(low, high)| high - low);
    let (low, high) = range(cut_um(machine, part, name).into_iter());
    BudgetRow {
        error: name.code(),
        meaning: name.meaning(),
        unit: name.unit(),
        size: size(machine, name),
        drift: drift(machine, name),
        e_x_um,
        e_y_um,
        e_z_um,
        cut_um: high - low,
    }
}

/// The diameter that is cut with this error alone, along the part and, for the spindle, over a
/// turn, µm.
fn cut_um(machine: &Prepared, part: &Part, name: ErrorName) -> Vec<f64> {
    let radius = 0.5 * part.diameter_mm;
    let at = |state: &Conditions, z: f64| {
        let station: Station = machine.settings.tool(radius, z);
        let values = ErrorValues::only(name, machine.motion.value(name, [radius, z], state));
        let pose = first_order::pose(machine.settings.chain, &station, &values);
        1e3 * cut_mm(part, machine.settings.tip_above_axis_mm, &pose)
    };
    let states = states(machine, name);
    states.iter().flat_map(|state| machine.z_mm.iter().map(move |z| at(state, *z))).collect()
}

/// From mm or rad to µm or µrad.
fn own_unit(name: ErrorName) -> f64 {
    if name.is_length() { 1e3 } else { 1e6 }
}

/// Positions of the axis of an error with the states there.
fn own_positions(machine: &Prepared, name: ErrorName) -> Vec<([f64; 2], Conditions)> {
    match name.axis() {
        Axis::X => machine.x_mm.iter().map(|x| ([*x, 0.0], machine.state)).collect(),
        Axis::Z => machine.z_mm.iter().map(|z| ([0.0, *z], machine.state)).collect(),
        Axis::C => states(machine, name).into_iter().map(|state| ([0.0, 0.0], state)).collect(),
    }
}

fn size(machine: &Prepared, name: ErrorName) -> f64 {
    if machine.motion.function(name).is_none() {
        return own_unit(name) * machine.motion.value(name, [0.0, 0.0], &machine.state);
    }
    let values = own_positions(machine, name);
    let (low, high) = range(values.iter().map(|(at, state)| machine.motion.value(name, *at, state)));
    own_unit(name) * (high - low)
}

fn drift(machine: &Prepared, name: ErrorName) -> f64 {
    let Some(function) = machine.motion.function(name) else { return 0.0 };
    let position = |at: [f64; 2]| if name.axis() == Axis::X { at[0] } else { at[1] };
    let drifts = own_positions(machine, name).into_iter();
    own_unit(name) * drifts.map(|(at, state)| function.drift(position(at), &state)).fold(0.0, larger)
}

/// Whichever is further from 0.
fn larger(a: f64, b: f64) -> f64 {
    if b.abs() > a.abs() { b } else { a }
}
