//! The contour of a stepped shaft with its sections marked, and their results.

use super::error::ReportError;
use super::html::Page;
use super::plot::{Chart, Mark, Series};
use crate::conformity::part_verdict::PartConformity;
use crate::plan::Contour;
use crate::run_folder::SectionResults;

/// Adds the drawing of the contour, a table of the sections, the tapers' own values and what is
/// excluded.
pub(super) fn section_report(
    page: &mut Page,
    contour: &Contour,
    nominal_mm: f64,
    results: &SectionResults,
) -> Result<(), ReportError> {
    page.heading("Sections");
    let svg = drawing(contour, nominal_mm).to_svg().map_err(ReportError::Draw)?;
    page.figure(
        &svg,
        "The contour that the last pass leaves: the drawing's diameters with the aims of its sections. Thick: lengths with stations, a \
         colour a section; everything else judges nothing.",
    );
    table(page, results);
    if !results.tapers.is_empty() {
        let mm = |v: f64| format!("{v:.4}");
        let rows: Vec<Vec<String>> = results
            .tapers
            .iter()
            .map(|t| {
                vec![
                    t.name.clone(),
                    format!("{:.2} to {:.2}", t.from_mm, t.to_mm),
                    format!("{} to {}", mm(t.nominal_from_mm), mm(t.nominal_to_mm)),
                    format!("{} to {}", mm(t.measured_from_mm), mm(t.measured_to_mm)),
                    format!("{:.2}", t.max_abs_deviation_mm * 1e3),
                ]
            })
            .collect();
        page.text("Tapers: diameters at both ends by a line through the readings; they judge no cylinder.");
        let header =
            ["taper", "z / mm", "drawn / mm", "measured / mm", "largest deviation from the drawn line / µm"];
        page.table(&header, &rows);
    }
    let excluded: Vec<Vec<String>> = results
        .excluded
        .iter()
        .map(|e| vec![format!("{:.2} to {:.2}", e.from_mm, e.to_mm), words(e.reason).to_owned()])
        .collect();
    page.text("Lengths without stations:");
    page.table(&["z / mm", "reason"], &excluded);
    Ok(())
}

fn words(reason: &str) -> &str {
    match reason {
        "taper" => "a taper, with the blur at its ends",
        "shoulder" => "a shoulder, with its chamfer, its fillet and its blur",
        _ => "not measured, or a remainder shorter than a station",
    }
}

/// Radius over z, both sides of the axis.
fn drawing(contour: &Contour, nominal_mm: f64) -> Chart {
    let radius = |relative: f64| 0.5 * (nominal_mm + relative);
    let outline = |side: f64| contour.knots.iter().map(|k| (k.z_mm, side * radius(k.relative_mm))).collect();
    let mut series = vec![
        Series::new("contour", Mark::Faint, 0, outline(1.0)),
        Series::new("", Mark::Faint, 0, outline(-1.0)),
    ];
    for (i, s) in contour.sections.iter().enumerate() {
        let side =
            |sign: f64| [s.clear_mm.0, s.clear_mm.1].map(|z| (z, sign * radius(s.relative_mm))).to_vec();
        series.push(Series::new(s.name.clone(), Mark::Line, i, side(1.0)));
        series.push(Series::new("", Mark::Line, i, side(-1.0)));
    }
    Chart {
        x_label: "z from the chuck / mm".into(),
        y_label: "radius / mm".into(),
        series,
        ..Chart::default()
    }
}

fn table(page: &mut Page, results: &SectionResults) {
    let um = |mm: f64| format!("{:.2}", mm * 1e3);
    let mm = |v: Option<f64>| v.map_or_else(String::new, |v| format!("{v:.4}"));
    let rows: Vec<Vec<String>> = results
        .sections
        .iter()
        .map(|s| {
            let limits = match (s.lower_mm, s.upper_mm) {
                (Some(low), Some(high)) => format!("{low:.4} to {high:.4}"),
                _ => String::new(),
            };
            vec![
                s.name.clone(),
                format!("{} to {}", s.from_mm, s.to_mm),
                format!("{:.4}", s.nominal_mm),
                limits,
                format!("{:.4}", s.aimed_mm),
                format!("{} of {}", s.stations_measured, s.stations),
                mm(s.mean_mm),
                um(s.max_abs_error_mm),
                s.true_max_abs_error_mm.map_or_else(|| "–".to_owned(), um),
                s.judged.map_or("", judged).to_owned(),
            ]
        })
        .collect();
    let header = [
        "section",
        "z / mm",
        "nominal / mm",
        "limits / mm",
        "aimed at / mm",
        "stations read",
        "mean / mm",
        "measured max |e| / µm",
        "true max |e| / µm",
        "judged",
    ];
    page.filled_columns(&header, &rows);
}

fn judged(verdict: PartConformity) -> &'static str {
    match verdict {
        PartConformity::Conforms => "in tolerance, proven",
        PartConformity::NotProven => "not proven",
        PartConformity::Violates => "out of tolerance",
    }
}
