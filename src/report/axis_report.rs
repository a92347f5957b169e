//! The axis of the part in the report of a run: how it bends in the image plane, and what turns with it.

use super::error::ReportError;
use super::html::Page;
use super::plot::{Chart, Mark, Series};
use crate::run_folder::AxisRow;

/// Adds the section; nothing where no pass has an axis.
///
/// # Errors
/// Where a chart cannot be drawn.
pub fn axis_section(page: &mut Page, rows: &[AxisRow]) -> Result<(), ReportError> {
    let Some(pass) = rows.iter().map(|r| r.pass).max() else { return Ok(()) };
    page.heading("Axis of the part").text(
        "Middle of both edges at every station. What stands still (sag, force, lie of the spindle) is seen in the image plane; what turns with the part \
         (eccentricity, bow) is seen in both planes, from spindle angles 90° apart. What stands still towards the camera moves no edge: it is not seen, \
         unless from a second viewing direction.",
    );
    let um = |mm: f64| format!("{:.2}", 1e3 * mm);
    let passes: std::collections::BTreeSet<u32> = rows.iter().map(|r| r.pass).collect();
    let table: Vec<Vec<String>> = passes
        .iter()
        .map(|pass| {
            let own = || rows.iter().filter(|r| r.pass == *pass);
            let bend = own().max_by(|a, b| a.bend_x_mm.abs().total_cmp(&b.bend_x_mm.abs()));
            let out = own()
                .filter(|r| r.run_out_mm.is_some())
                .max_by(|a, b| a.run_out_mm.partial_cmp(&b.run_out_mm).unwrap_or(std::cmp::Ordering::Equal));
            let dash = || "–".to_owned();
            vec![
                pass.to_string(),
                bend.map_or_else(dash, |r| um(r.bend_x_mm)),
                bend.map_or_else(dash, |r| um(2.0 * r.u_bend_x_mm)),
                bend.map_or_else(dash, |r| format!("{:.1}", r.z_mm)),
                out.and_then(|r| r.run_out_mm).map_or_else(dash, um),
                out.and_then(|r| r.u_turning_mm).map_or_else(dash, |u| um(4.0 * u)),
                out.map_or_else(dash, |r| format!("{:.1}", r.z_mm)),
            ]
        })
        .collect();
    let header = [
        "pass",
        "largest bend / µm",
        "U (k = 2) / µm",
        "at z / mm",
        "largest run-out of the axis / µm",
        "U (k = 2) / µm",
        "at z / mm",
    ];
    page.table(&header, &table);
    let of_pass = |f: &dyn Fn(&AxisRow) -> Option<f64>| -> Vec<(f64, f64)> {
        rows.iter().filter(|r| r.pass == pass).filter_map(|r| Some((r.z_mm, 1e3 * f(r)?))).collect()
    };
    let chart = Chart {
        x_label: "z from the chuck / mm".into(),
        y_label: "axis / µm".into(),
        series: vec![
            Series::new("bend, still, upwards", Mark::Line, 0, of_pass(&|r| Some(r.bend_x_mm))),
            Series::new("turns, upwards at 0°", Mark::Line, 1, of_pass(&|r| r.turning_x_mm)),
            Series::new("turns, towards the camera at 0°", Mark::Line, 2, of_pass(&|r| r.turning_y_mm)),
        ],
        ..Chart::default()
    };
    let svg = chart.to_svg().map_err(ReportError::Draw)?;
    page.figure(
        &svg,
        &format!("Axis after pass {pass}: the part that stands still, from the chord between the first and the last station, and the part that turns."),
    );
    Ok(())
}
