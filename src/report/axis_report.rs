//! The axis of the part in the report of a run: the line at rest and the one that turns, measured
//! and true, in one picture per pass.

use super::error::ReportError;
use super::html::Page;
use super::plot::{Chart, Mark, Series, band};
use super::shaft_report::is_bent;
use crate::run_folder::{AxisRow, TrueAxisRow};

/// Colours of the plane of the image, the plane towards the camera, and the true values.
const IMAGE: usize = 0;
const TOWARDS_CAMERA: usize = 2;
const TRUE: usize = 6;
/// Colour of true values that are not measured.
const UNSEEN: usize = 1;

/// Adds the section, the last pass open and those before folded; nothing where no pass has an axis.
/// Returns the file that goes beside the page.
///
/// # Errors
/// Where a chart cannot be drawn.
pub(crate) fn axis_section(
    page: &mut Page,
    rows: &[AxisRow],
    truth: &[TrueAxisRow],
) -> Result<Option<(String, Vec<u8>)>, ReportError> {
    let bent = truth.iter().any(is_bent);
    let seen = rows.iter().map(|r| r.pass);
    let Some(last) = seen.chain(truth.iter().filter(|_| bent).map(|t| t.pass)).max() else { return Ok(None) };
    page.heading("Axis of the part");
    table(page, rows);
    let svg = of_pass(page, rows, truth, last)?;
    let mut before: Vec<u32> = rows.iter().map(|r| r.pass).filter(|pass| *pass < last).collect();
    before.dedup();
    for pass in before {
        page.folded(&format!("The axis after pass {pass}"), |page| {
            of_pass(page, rows, truth, pass).map(drop)
        })?;
    }
    Ok((!svg.is_empty()).then(|| ("plots/axis.svg".to_owned(), svg.into_bytes())))
}

/// Explanation of the axis, and its largest values per pass.
fn table(page: &mut Page, rows: &[AxisRow]) {
    if rows.is_empty() {
        return;
    }
    page.text(
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
}

/// The part at rest and the turning part of a pass, measured with U, and true where the simulation
/// provides it; returns the first picture.
fn of_pass(
    page: &mut Page,
    rows: &[AxisRow],
    truth: &[TrueAxisRow],
    pass: u32,
) -> Result<String, ReportError> {
    let measured = |name: &str, colour: usize, f: &dyn Fn(&AxisRow) -> Option<(f64, f64)>| {
        let own = rows.iter().filter(|r| r.pass == pass);
        let points: Vec<(f64, f64, f64)> =
            own.filter_map(|r| f(r).map(|(value, u)| (r.z_mm, 1e3 * value, 2e3 * u))).collect();
        let line = points.iter().map(|p| (p.0, p.1)).collect();
        [
            Series::new("U (k = 2)", Mark::Band, colour, band(points.into_iter())),
            Series::new(name, Mark::Line, colour, line),
        ]
    };
    let true_line = |name: &str, colour: usize, f: &dyn Fn(&TrueAxisRow) -> f64| {
        let own = truth.iter().filter(|t| t.pass == pass).map(|t| (t.z_mm, 1e3 * f(t)));
        Series::new(name, Mark::Dashed, colour, own.collect())
    };
    let mut still: Vec<Series> =
        measured("in the image, measured", IMAGE, &|r| Some((r.x_mm, r.u_x_mm))).into();
    still.push(true_line("in the image, true", TRUE, &|t| t.still_x_mm));
    still.push(true_line("towards the camera, true: not seen", UNSEEN, &|t| t.still_y_mm));
    let svg = chart(
        page,
        still,
        "what stands still / µm",
        &format!(
            "Pass {pass}, what stands still (weight, tailstock, force, lie of the spindle) from the optical axis. Towards the camera it moves no \
             edge."
        ),
    )?;
    let up = |r: &AxisRow| Some((r.turning_x_mm?, r.u_turning_mm?));
    let towards = |r: &AxisRow| Some((r.turning_y_mm?, r.u_turning_mm?));
    let mut turning: Vec<Series> = measured("upwards, measured", IMAGE, &up).into();
    turning.extend(measured("towards the camera, measured", TOWARDS_CAMERA, &towards));
    turning.push(true_line("upwards, true", TRUE, &|t| t.turning_x_mm));
    turning.push(true_line("towards the camera, true", UNSEEN, &|t| t.turning_y_mm));
    let caption = format!(
        "Pass {pass}, what turns with the part (chuck, bow) at spindle angle 0°: the camera sees both planes of it, from angles 90° apart."
    );
    chart(page, turning, "what turns / µm", &caption)?;
    Ok(svg)
}

/// Adds a chart of the series that have points.
fn chart(page: &mut Page, series: Vec<Series>, y_label: &str, caption: &str) -> Result<String, ReportError> {
    let series: Vec<Series> = series.into_iter().filter(|s| !s.points.is_empty()).collect();
    if series.is_empty() {
        return Ok(String::new());
    }
    let chart = Chart {
        x_label: "z from the chuck / mm".into(),
        y_label: y_label.into(),
        series,
        ..Chart::default()
    };
    let svg = chart.to_svg().map_err(ReportError::Draw)?;
    page.figure(&svg, caption);
    Ok(svg)
}
