//! `shadowgauge study correlation`: this gauge's readings of parts beside another's, from a table.

use std::path::{Path, PathBuf};

use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::{StudyFolder, csv_text, json_text};
use crate::report::html::{Page, Tone};
use crate::report::plot::{Chart, Mark, Series};
use crate::studies::correlation::{ComparedPart, Correlation, correlation};
use crate::text_table::{Comments, TextTable};

/// Arguments of `study correlation`.
#[derive(Debug, clap::Args)]
pub(crate) struct StudyCorrelationArgs {
    /// A table as CSV, a row a part: part, d_mm (this gauge), reference_mm (the other), and
    /// expanded_u_mm, reference_expanded_u_mm (U, k = 2); separated by commas, semicolons or tabs.
    table: PathBuf,
    /// U (k = 2) of this gauge where the table has no expanded_u_mm, µm.
    #[arg(long, value_name = "U", value_parser = above_zero)]
    expanded_u_um: Option<f64>,
    /// U (k = 2) of the other gauge where the table has no reference_expanded_u_mm, µm.
    #[arg(long, value_name = "U", value_parser = above_zero)]
    reference_expanded_u_um: Option<f64>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write correlation.json, correlation.csv and report.html into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

fn above_zero(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("a number above 0 is needed".to_owned()),
    }
}

/// Runs the study; exit 1 where a part's E_n exceeds 1.
///
/// # Errors
/// Exit 2 for a table that is refused, 3 for one that cannot be read and a disk that fails.
pub(crate) fn run(args: &StudyCorrelationArgs) -> CommandResult {
    let folder = StudyFolder::claim(args.out.as_deref())?;
    let refused = |e: &dyn std::fmt::Display| Failure::refuse(format!("{}: {e}", args.table.display()));
    let found = correlation(&read(args)?).map_err(|e| refused(&e))?;
    StudyFolder::fill(folder, |folder| {
        folder.write("correlation.json", json_text(&found)?.as_bytes())?;
        folder.write("correlation.csv", &csv_text(&found.parts)?)?;
        folder.write("report.html", page(&found)?.as_bytes())
    })?;
    if args.json {
        say_line!("{}", json_text(&found)?);
    } else {
        in_words(&found);
    }
    Ok(if found.disagreeing == 0 { Outcome::Done } else { Outcome::OutOfTolerance })
}

/// Columns that the table must have.
const COLUMNS: [&str; 3] = ["part", "d_mm", "reference_mm"];

fn read(args: &StudyCorrelationArgs) -> Result<Vec<ComparedPart>, Failure> {
    let named = |e: String| format!("{}: {e}", args.table.display());
    let bytes = std::fs::read(&args.table).map_err(|e| Failure::fail(named(e.to_string())))?;
    let refuse = |e: String| Failure::refuse(named(e));
    let table = TextTable::parse(&bytes, &COLUMNS, Comments::Hash).map_err(|e| refuse(e.to_string()))?;
    table.require(&COLUMNS).map_err(refuse)?;
    let mut parts = Vec::new();
    for cells in table.rows() {
        let cells = cells.map_err(|e| refuse(e.to_string()))?;
        let number = |name: &str| cells.number(name).map_err(refuse);
        let expanded = |name: &str, for_all_um: Option<f64>| {
            let of_row = cells.text(name).filter(|text| !text.is_empty());
            stated(of_row.map(|_| number(name)).transpose()?, for_all_um, name, &args.table)
        };
        parts.push(ComparedPart {
            part: cells.text("part").unwrap_or_default().to_owned(),
            d_mm: number("d_mm")?,
            expanded_u_mm: expanded("expanded_u_mm", args.expanded_u_um)?,
            reference_mm: number("reference_mm")?,
            reference_expanded_u_mm: expanded("reference_expanded_u_mm", args.reference_expanded_u_um)?,
        });
    }
    Ok(parts)
}

/// U of a row, otherwise the one for all, mm.
fn stated(of_row: Option<f64>, for_all_um: Option<f64>, column: &str, table: &Path) -> Result<f64, Failure> {
    of_row.or_else(|| for_all_um.map(|um| 1e-3 * um)).ok_or_else(|| {
        let option = column.replace('_', "-").replace("-mm", "-um");
        let right = format!("a row has no {column}: fill the column, or give --{option} for all parts");
        Failure::refuse(format!("{}: {right}", table.display()))
    })
}

fn in_words(found: &Correlation) {
    say_line!("{:<16} {:>12} {:>16} {:>10} {:>8}", "part", "D / mm", "difference / µm", "U / µm", "E_n");
    for p in &found.parts {
        say_line!(
            "{:<16} {:12.5} {:16.3} {:10.3} {:8.2}{}",
            p.part,
            p.reference_mm,
            p.difference_um,
            p.expanded_u_um,
            p.e_n,
            if p.agrees { "" } else { "  disagrees" }
        );
    }
    say_line!("{}", line_words(found));
    found.words.iter().for_each(|words| say_line!("{words}"));
}

fn line_words(found: &Correlation) -> String {
    format!(
        "line (both uncertain): {:+.3} ± {:.3} µm at {:.4} mm, {:+.4} ± {:.4} µm a mm; scatter {:.2} times what is stated",
        found.offset_um,
        found.expanded_u_offset_um,
        found.middle_mm,
        found.slope_um_per_mm,
        found.expanded_u_slope_um_per_mm,
        found.scatter_ratio
    )
}

fn page(found: &Correlation) -> Result<String, Failure> {
    let mut page = Page::new("Two gauges on the same parts");
    let tone = if found.disagreeing == 0 { Tone::Good } else { Tone::Bad };
    page.verdict(tone, &format!("{} of {} parts disagree (|E_n| > 1)", found.disagreeing, found.parts.len()));
    found.words.iter().for_each(|words| {
        page.text(words);
    });
    page.text(&line_words(found));
    let svg = chart(found).to_svg().map_err(Failure::fail)?;
    page.figure(&svg, "Difference over the other gauge's diameter with U of each, and the line.");
    let row = |p: &crate::studies::correlation::PartDifference| {
        vec![
            p.part.clone(),
            format!("{:.5}", p.reference_mm),
            format!("{:+.3}", p.difference_um),
            format!("{:.3}", p.expanded_u_um),
            format!("{:+.2}", p.e_n),
        ]
    };
    let rows: Vec<Vec<String>> = found.parts.iter().map(row).collect();
    page.table(&["part", "D / mm", "difference / µm", "U / µm", "E_n"], &rows);
    Ok(page.finish())
}

fn chart(found: &Correlation) -> Chart {
    let parts = || found.parts.iter();
    let line = |mm: f64| (mm, found.offset_um + found.slope_um_per_mm * (mm - found.middle_mm));
    let ends =
        parts().fold((f64::INFINITY, 0.0_f64), |(l, h), p| (l.min(p.reference_mm), h.max(p.reference_mm)));
    let bars = crate::report::plot::bars(parts().map(|p| (p.reference_mm, p.difference_um, p.expanded_u_um)));
    Chart {
        x_label: "diameter by the other gauge / mm".to_owned(),
        y_label: "difference / µm".to_owned(),
        series: vec![
            Series::new("U (k = 2)", Mark::Bars, 0, bars),
            Series::new("parts", Mark::Dots, 0, parts().map(|p| (p.reference_mm, p.difference_um)).collect()),
            Series::new("line", Mark::Line, 1, vec![line(ends.0), line(ends.1)]),
        ],
        ..Chart::default()
    }
}
