//! What the errors of the lathe did in a run: to the cut, by pass, and to the head that looked at
//! it. Of the simulation's own geometry, for comparison only.

use super::error::ReportError;
use super::html::Page;
use super::plot::{Chart, Mark, Series};
use crate::job::{Job, MachineRow};

/// Files that go beside the page, by their names below the run folder.
type Files = Vec<(String, Vec<u8>)>;

/// Adds the section; nothing where the machine stood as commanded.
///
/// # Errors
/// Where a chart cannot be drawn.
pub(crate) fn machine_section(page: &mut Page, job: &Job, passes: usize) -> Result<Files, ReportError> {
    let rows = job.machine_rows(passes).map_err(|e| ReportError::Draw(e.to_string()))?;
    let Some(last) = rows.last().map(|row| row.pass) else { return Ok(Files::new()) };
    let of_last: Vec<&MachineRow> = rows.iter().filter(|row| row.pass == last).collect();
    page.heading("Errors of the machine");
    page.text(&introduction(job));
    figures(page, &rows);
    let cut = drawn(
        page,
        &cut_chart(&of_last),
        "What the errors of the lathe add to the diameter cut in the last pass.",
    )?;
    let head = drawn(
        page,
        &head_chart(&of_last),
        "Where the head stood relative to the part, less where it should, with a station in the middle of its field.",
    )?;
    Ok(vec![("plots/machine_cut.svg".to_owned(), cut), ("plots/machine_head.svg".to_owned(), head)])
}

fn introduction(job: &Job) -> String {
    let compensates = job.machine.as_ref().is_some_and(|machine| machine.compensate);
    let by = if compensates {
        "The control subtracts its own table of the static errors, a value a station; neither gauge nor controller was given either."
    } else {
        "The control does not compensate them; neither gauge nor controller was given any of it."
    };
    format!(
        "The simulated lathe's geometric errors displace the tool (\"cut\", in the diameters above) and the head that looks at the part. {by} \
         The measured axis of the part has the head's own straightness in it. Rows of all stations: truth_machine.csv."
    )
}

/// Largest magnitude of a column, as text.
fn most(rows: &[&MachineRow], column: fn(&MachineRow) -> f64) -> String {
    format!("{:.3}", rows.iter().map(|row| column(row).abs()).fold(0.0, f64::max))
}

/// The largest values a pass.
fn figures(page: &mut Page, rows: &[MachineRow]) {
    let passes: std::collections::BTreeSet<u32> = rows.iter().map(|row| row.pass).collect();
    let line = |pass: &u32| {
        let own: Vec<&MachineRow> = rows.iter().filter(|row| row.pass == *pass).collect();
        vec![
            pass.to_string(),
            most(&own, |row| row.cut_um),
            most(&own, |row| row.cut_um - row.cut_first_order_um),
            most(&own, |row| row.compensated_um),
            most(&own, |row| row.left_um),
            most(&own, |row| row.head_x_um),
            most(&own, |row| row.head_y_um),
            most(&own, |row| row.head_b_urad),
        ]
    };
    let table: Vec<Vec<String>> = passes.iter().map(line).collect();
    let header = [
        "pass",
        "cut: largest / µm of diameter",
        "less first order / µm",
        "compensated / µm",
        "left / µm",
        "head along X / µm",
        "head along Y / µm",
        "head about Y / µrad",
    ];
    page.filled_columns(&header, &table);
}

fn line(
    rows: &[&MachineRow],
    (name, mark, colour): (&str, Mark, usize),
    column: fn(&MachineRow) -> f64,
) -> Series {
    Series::new(name, mark, colour, rows.iter().map(|row| (row.z_mm, column(row))).collect())
}

fn cut_chart(rows: &[&MachineRow]) -> Chart {
    let mut series = vec![line(rows, ("cut", Mark::LineDots, 0), |row| row.cut_um)];
    if rows.iter().any(|row| row.compensated_um != 0.0) {
        series.push(line(rows, ("compensated", Mark::Dashed, 1), |row| row.compensated_um));
        series.push(line(rows, ("left", Mark::LineDots, 2), |row| row.left_um));
    }
    Chart {
        x_label: "z from the chuck / mm".into(),
        y_label: "diameter / µm".into(),
        series,
        ..Chart::default()
    }
}

fn head_chart(rows: &[&MachineRow]) -> Chart {
    Chart {
        x_label: "z from the chuck / mm".into(),
        y_label: "displacement of the head / µm".into(),
        series: vec![
            line(rows, ("along X", Mark::LineDots, 0), |row| row.head_x_um),
            line(rows, ("along Y, towards the lens", Mark::LineDots, 1), |row| row.head_y_um),
            line(rows, ("along Z", Mark::LineDots, 2), |row| row.head_z_um),
        ],
        ..Chart::default()
    }
}

/// Adds a chart to the page and returns its SVG.
fn drawn(page: &mut Page, chart: &Chart, caption: &str) -> Result<Vec<u8>, ReportError> {
    let svg = chart.to_svg().map_err(ReportError::Draw)?;
    page.figure(&svg, caption);
    Ok(svg.into_bytes())
}
