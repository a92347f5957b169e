//! What `calibrate machine` writes beside `machine.json`: tables of a control.

use crate::cli::failure::Failure;
use crate::cli::input_output::{StudyFolder, csv_text};
use crate::identification::export::{knot_program, knots, screw_table, tool_errors};
use crate::identification::iso230_2::OneDirection;
use crate::identification::{Identification, IdentifiedMachine};

/// What the tables are made of.
pub(super) struct Tables<'a> {
    /// The identification.
    pub found: &'a Identification,
    /// Radius of the cylinder whose knots are written, mm.
    pub radius_mm: Option<f64>,
    /// How far a straight line between two knots may leave the error, mm.
    pub chord_mm: f64,
    /// The texts of simulated readings, by set.
    pub simulated: Vec<Option<String>>,
}

/// Writes all tables.
///
/// # Errors
/// Exit 3 where the disk or the permissions refuse.
pub(super) fn write_tables(folder: &StudyFolder, of: &Tables<'_>) -> Result<(), Failure> {
    let (file, solution) = (&of.found.file, &of.found.chosen);
    let machine = &file.machine;
    folder.write("errors.csv", &csv_text(&error_rows(file))?)?;
    folder.write("compensation.csv", &csv_text(&tool_errors(solution, machine))?)?;
    folder.write("positioning.csv", &csv_text(&positioning_rows(file))?)?;
    let [x_from, _] = machine.x_travel_mm;
    let [z_from, z_to] = machine.z_travel_mm;
    let x_at = of.radius_mm.unwrap_or(x_from.max(0.0));
    let z_at = 0.0_f64.clamp(z_from, z_to);
    folder.write("linuxcnc_x.comp", screw_table(solution, machine, true, z_at).as_bytes())?;
    folder.write("linuxcnc_z.comp", screw_table(solution, machine, false, x_at).as_bytes())?;
    if let Some(radius) = of.radius_mm {
        let knots = knots(solution, machine, radius, of.chord_mm);
        folder.write("knots.csv", &csv_text(&knots)?)?;
        folder.write("knots.ngc", knot_program(&knots, &file.name).as_bytes())?;
    }
    for (k, text) in of.simulated.iter().enumerate() {
        if let Some(text) = text {
            folder.write(&format!("readings_{k}.csv"), text.as_bytes())?;
        }
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
        let one = |names: [&'static str; 3], of: Option<OneDirection>| {
            of.map_or_else(Vec::new, |d| names.into_iter().zip([d.a, d.r, d.e]).collect())
        };
        let mut all: Vec<(&'static str, f64)> = one(["A_forward", "R_forward", "E_forward"], p.forward);
        all.extend(one(["A_backward", "R_backward", "E_backward"], p.backward));
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
