//! The identified errors as tables of a control.
//!
//! LinuxCNC (`COMP_FILE`, type 0): a line of nominal position, actual position where it was reached
//! upwards, and downwards, ascending, at most 256 lines; X as radius. The control's BACKLASH is
//! then ignored, the reversal is in the table. A screw table is of one axis alone: it holds what
//! the tool departs along the axis while that slide alone moves, the angles at the tool's levers
//! included, and the other slide stands at its reference. What is left (e_X over z, e_Z over x) are
//! knots of the program.

use super::solution::Solution;
use crate::machine::MachineSettings;
use crate::machine::conditions::Direction;

/// Most lines that LinuxCNC reads.
const MOST_LINES: usize = 256;
/// Lines of a table: every hundredth of the travel.
const LINES: usize = 101;
/// Positions along each axis of the table of the tool's error.
const GRID: usize = 21;

/// The tool's error at a position of both slides, a row of `compensation.csv`.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub(crate) struct ToolErrorRow {
    /// Position of X, mm.
    pub x_mm: f64,
    /// Position of Z, mm.
    pub z_mm: f64,
    /// Along X, µm of radius.
    pub e_x_um: f64,
    /// Its standard uncertainty, µm.
    pub u_x_um: f64,
    /// Along Z, µm.
    pub e_z_um: f64,
    /// Its standard uncertainty, µm.
    pub u_z_um: f64,
}

/// A knot of a program along a cylinder.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub(crate) struct Knot {
    /// Commanded Z, mm.
    pub z_mm: f64,
    /// Commanded X, mm of radius.
    pub x_mm: f64,
}

/// The tool's error over the range, z running fastest.
pub(crate) fn tool_errors(solution: &Solution, machine: &MachineSettings) -> Vec<ToolErrorRow> {
    let (xs, zs) = (spaced(machine.x_travel_mm, GRID), spaced(machine.z_travel_mm, GRID));
    let row = |x_mm: f64, z_mm: f64| {
        let along = |k: usize| solution.tool(machine, [x_mm, z_mm], k, Direction::Forward);
        let (x, z) = (along(0), along(2));
        ToolErrorRow {
            x_mm,
            z_mm,
            e_x_um: 1e3 * x.value,
            u_x_um: 1e3 * x.u,
            e_z_um: 1e3 * z.value,
            u_z_um: 1e3 * z.u,
        }
    };
    xs.iter().flat_map(|x| zs.iter().map(|z| row(*x, *z))).collect()
}

/// A screw table of LinuxCNC of X or Z, with the other slide at `other_mm`.
pub(crate) fn screw_table(
    solution: &Solution,
    machine: &MachineSettings,
    is_x: bool,
    other_mm: f64,
) -> String {
    let travel = if is_x { machine.x_travel_mm } else { machine.z_travel_mm };
    let along = if is_x { 0 } else { 2 };
    let at = |p: f64| if is_x { [p, other_mm] } else { [other_mm, p] };
    let actual = |p: f64, direction| p + solution.tool(machine, at(p), along, direction).value;
    spaced(travel, LINES.min(MOST_LINES))
        .into_iter()
        .map(|p| {
            let (up, down) = (actual(p, Direction::Forward), actual(p, Direction::Backward));
            format!("{p:.6} {up:.7} {down:.7}\n")
        })
        .collect()
}

/// The knots of a program that turns a cylinder of a radius: between them the straight line leaves
/// what is commanded by at most `chord_mm`.
pub(crate) fn knots(
    solution: &Solution,
    machine: &MachineSettings,
    radius_mm: f64,
    chord_mm: f64,
) -> Vec<Knot> {
    let fine: Vec<Knot> = spaced(machine.z_travel_mm, 10 * LINES)
        .into_iter()
        .map(|z_mm| {
            let error = solution.tool(machine, [radius_mm, z_mm], 0, Direction::Backward).value;
            Knot { z_mm, x_mm: radius_mm - error }
        })
        .collect();
    let mut knots = vec![fine[0]];
    let mut from = 0;
    while from + 1 < fine.len() {
        let mut to = from + 1;
        while to + 1 < fine.len() && chord(&fine[from..=to + 1]) <= chord_mm {
            to += 1;
        }
        knots.push(fine[to]);
        from = to;
    }
    knots
}

/// Largest distance along X of points from the line from the first to the last.
fn chord(points: &[Knot]) -> f64 {
    let (first, last) = (points[0], points[points.len() - 1]);
    let slope = (last.x_mm - first.x_mm) / (last.z_mm - first.z_mm);
    let off = |p: &Knot| (p.x_mm - first.x_mm - slope * (p.z_mm - first.z_mm)).abs();
    points.iter().map(off).fold(0.0, f64::max)
}

/// A program of LinuxCNC along the knots towards the chuck: X as diameter, feed as it stands.
pub(crate) fn knot_program(knots: &[Knot], name: &str) -> String {
    let mut text = format!("(compensated generatrix: {name}; G7 diameter, towards the chuck)\nG7\n");
    for knot in knots.iter().rev() {
        text += &format!("G1 X{:.5} Z{:.4}\n", 2.0 * knot.x_mm, knot.z_mm);
    }
    text
}

/// Equally spaced positions, both ends included.
fn spaced([from, to]: [f64; 2], count: usize) -> Vec<f64> {
    let step = (to - from) / (count - 1) as f64;
    (0..count).map(|k| if k + 1 == count { to } else { from + step * k as f64 }).collect()
}
