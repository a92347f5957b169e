//! The shaft in the machine: forces of every pass, a turn as an animation.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use super::html::Page;
use crate::run_folder::{PassRow, StationRow, TrueAxisRow};

/// Spindle angles of the animation.
const ANGLES: usize = 24;
/// Duration of a turn in it, s.
const TURN_S: f64 = 4.0;
/// Size of the picture, px.
const SIZE: (f64, f64) = (860.0, 300.0);
/// Half the height at which the nominal shaft is drawn, px.
const HALF_PX: f64 = 60.0;
/// Drawn size of the largest deviation, px.
const LARGEST_PX: f64 = 45.0;
/// Deviation of the axis from the spindle's below which a shaft is drawn straight, mm.
const STRAIGHT_MM: f64 = 1e-6;

/// Adds a turn of the last pass as an animation; returns the file that goes beside the page, none
/// for a straight shaft.
pub(crate) fn turn_picture(
    page: &mut Page,
    passes: &[PassRow],
    stations: &[StationRow],
    axis: &[TrueAxisRow],
) -> Option<(String, Vec<u8>)> {
    let last = axis.iter().map(|a| a.pass).max()?;
    let rows: Vec<&TrueAxisRow> = axis.iter().filter(|a| a.pass == last).collect();
    if !rows.iter().any(|a| is_bent(a)) {
        return None;
    }
    let of_pass: Vec<&StationRow> = stations.iter().filter(|s| s.pass == last).collect();
    let nominal = passes.iter().find(|p| p.pass == last).map_or(f64::NAN, |p| p.nominal_mm);
    let (picture, times) = turn(&rows, &of_pass, nominal);
    page.figure(
        &picture,
        &format!(
            "A turn of the last pass as the camera sees it: outline by the measured diameter and dashed axis, deviations drawn {times:.0} times as \
             large as the shaft's length; dotted: the spindle's axis."
        ),
    );
    Some(("plots/turn.svg".to_owned(), picture.into_bytes()))
}

/// Whether an axis deviates from the spindle's.
pub(crate) fn is_bent(a: &TrueAxisRow) -> bool {
    [a.still_x_mm, a.still_y_mm, a.turning_x_mm, a.turning_y_mm].iter().any(|v| v.abs() > STRAIGHT_MM)
}

/// Adds the forces of every pass, where the cell has them.
pub(crate) fn forces(page: &mut Page, passes: &[PassRow]) {
    if passes.iter().all(|p| p.radial_force_n.is_none()) {
        return;
    }
    let cell = |v: Option<f64>, digits: usize| v.map_or("–".to_owned(), |v| format!("{v:.digits$}"));
    let rows: Vec<Vec<String>> = passes
        .iter()
        .map(|p| {
            vec![
                p.pass.to_string(),
                cell(p.radial_force_n, 1),
                cell(p.tangential_force_n, 1),
                cell(p.feed_force_n, 1),
                cell(p.deflection_um, 2),
                cell(p.tangential_error_um, 3),
                cell(p.feed_mark_um, 3),
            ]
        })
        .collect();
    let header = [
        "pass",
        "radial force / N",
        "tangential force / N",
        "feed force / N",
        "deflection at the tool / µm",
        "tangential error, at most / µm",
        "feed marks / µm",
    ];
    page.heading("Forces").text(
        "Largest values of every pass by the simulation's force law (ISO 3002-4: passive, cutting and feed force). A radial deflection \
         counts twice in the diameter, a tangential one as 2(√(r² + u²) − r); feed marks are f²/8r high.",
    );
    page.table(&header, &rows);
}

/// An animated SVG, and the magnification of its deviations.
fn turn(axis: &[&TrueAxisRow], stations: &[&StationRow], nominal_mm: f64) -> (String, f64) {
    let turned = |a: &TrueAxisRow, phi: f64| {
        let (sin, cos) = phi.sin_cos();
        a.still_x_mm + a.turning_x_mm * cos - a.turning_y_mm * sin
    };
    let deviation = |i: usize| stations.get(i).and_then(|s| s.d_mm).map_or(0.0, |d| 0.5 * (d - nominal_mm));
    let phis: Vec<f64> = (0..=ANGLES).map(|i| TAU * i as f64 / ANGLES as f64).collect();
    let mut largest = STRAIGHT_MM;
    for (i, a) in axis.iter().enumerate() {
        for phi in &phis {
            largest = largest.max(turned(a, *phi).abs() + deviation(i).abs());
        }
    }
    let length = axis.last().map_or(1.0, |a| a.z_mm);
    let (left, width) = (20.0, SIZE.0 - 40.0);
    let (per_mm, middle) = (LARGEST_PX / largest, 0.5 * SIZE.1);
    let path = |side: f64, phi: f64| {
        let mut d = String::new();
        for (i, a) in axis.iter().enumerate() {
            let up = turned(a, phi) + side * deviation(i);
            let (x, y) = (left + width * a.z_mm / length, middle - side * HALF_PX - per_mm * up);
            let _ = write!(d, "{}{x:.1} {y:.1}", if i == 0 { "M" } else { "L" });
        }
        d
    };
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"The shaft over a turn: outline and axis\">\
         <rect class=\"paper\" width=\"{}\" height=\"{}\" fill=\"#ffffff\"/>\
         <line class=\"rule\" x1=\"{left}\" y1=\"{middle}\" x2=\"{}\" y2=\"{middle}\" stroke=\"#8c8c8c\" stroke-dasharray=\"2 4\"/>",
        SIZE.0,
        SIZE.1,
        SIZE.0,
        SIZE.1,
        left + width
    );
    let outline = "class=\"s0\" stroke=\"#0072b2\"";
    let own_axis = "class=\"s1\" stroke=\"#d55e00\" stroke-dasharray=\"8 4\"";
    for (side, look) in [(1.0, outline), (0.0, own_axis), (-1.0, outline)] {
        let values: Vec<String> = phis.iter().map(|phi| path(side, *phi)).collect();
        let _ = write!(
            svg,
            "<path fill=\"none\" {look} stroke-width=\"2\" d=\"{}\"><animate attributeName=\"d\" dur=\"{TURN_S}s\" \
             repeatCount=\"indefinite\" values=\"{}\"/></path>",
            values[0],
            values.join(";")
        );
    }
    svg.push_str("</svg>");
    (svg, per_mm / (width / length))
}
