//! `shadowgauge reproduce 004`: the paper on tool wear.

use std::path::PathBuf;

use super::tables;
use crate::cli::failure::{CommandResult, Failure};
use crate::cli::input_output::{StudyFolder, csv_text};
use crate::report::html::Page;
use crate::report::plot::{Chart, Mark, Series};
use crate::studies::reproduce_004::{self, Curves, Inputs, Reproduction};

/// Arguments of `reproduce 004`.
#[derive(Debug, clap::Args)]
pub(crate) struct Reproduce004Args {
    /// Half angles of the cones of workpieces 1 and 2, degrees, which the paper does not give:
    /// rows that need them are undetermined without.
    #[arg(long, value_name = "DEG", value_delimiter = ',', num_args = 1..)]
    cone_deg: Vec<f64>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write report.html, rows.csv and plots into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Parts of the paper and the prefixes of their rows' ids.
const PARTS: [(&str, &[&str]); 6] = [
    ("The flank (section 2, Table 1)", &["flank."]),
    ("The nose by vision (section 2)", &["nose.", "lsd.", "eq6.", "eq7.", "eq10.", "insert."]),
    (
        "The four workpieces and the lathe (Tables 2 to 4)",
        &["part1.", "part2.", "part3.", "part4.", "rate.", "table2.", "table3."],
    ),
    (
        "Where the paper disagrees with itself: compensation",
        &["c01.", "c02.", "c03.", "c04.", "c05.", "c06.", "c07."],
    ),
    ("Where the paper disagrees with itself: the rest", &["c08.", "c09.", "c10.", "c11.", "c12.", "c13."]),
    ("The paper's nose in e(a)", &["model."]),
];

/// Computes every row.
///
/// # Errors
/// Exit 2 for angles that are refused, 3 for a disk that fails.
pub(crate) fn run(args: &Reproduce004Args) -> CommandResult {
    let cone_deg = match args.cone_deg[..] {
        [] => None,
        [one, two] => Some([one, two]),
        _ => {
            let count = args.cone_deg.len();
            return Err(Failure::refuse(format!(
                "--cone-deg: two half angles are needed, of workpiece 1 and of workpiece 2, {count} given: e.g. --cone-deg 24,37.6"
            )));
        }
    };
    let inputs = Inputs { cone_deg, ..Inputs::default() };
    let found = reproduce_004::run(&inputs).map_err(Failure::refuse)?;
    let folder = StudyFolder::claim(args.out.as_deref())?;
    StudyFolder::fill(folder, |folder| write(folder, &found))?;
    tables::print(&found.rows, args.json)
}

fn write(folder: &StudyFolder, found: &Reproduction) -> Result<(), Failure> {
    let mut page = Page::new("Reproduction: tool wear by vision (Zhang, Lu, Xia, Zhang, Zhu 2025)");
    page.text(tables::VERDICTS);
    page.text(&tables::summary(&found.rows));
    for (heading, file, caption, chart) in [
        (
            "What registers and ways leave of the paper's nose",
            "e_of_a",
            "Material left along the normal over the angle of the surface: 0° a cylinder, 90° an end face, between them cones and \
             arcs. Bars: the workpieces' mean errors as distances along the normal, from after (below) to before compensation \
             (above); the cones at the half angle that their compensation needs, or that is stated.",
            registers(&found.curves),
        ),
        (
            "Table 4",
            "workpieces",
            "Mean errors of the four workpieces along the normal, and what the paper's d would leave of each.",
            workpieces(&found.curves),
        ),
    ] {
        let svg = chart.to_svg().map_err(Failure::fail)?;
        page.heading(heading);
        page.figure(&svg, caption);
        folder.write(&format!("{file}.svg"), svg.as_bytes())?;
    }
    tables::tables(&mut page, &found.rows, &PARTS);
    folder.write("rows.csv", &csv_text(&found.rows)?)?;
    folder.write("report.html", page.finish().as_bytes())
}

fn registers(curves: &Curves) -> Chart {
    let line = |(k, curve): (usize, &reproduce_004::Curve)| {
        let mark = if curve.points.len() > 1 { Mark::Line } else { Mark::Dots };
        Series::new(&curve.name, mark, k, curve.points.clone())
    };
    let bars = curves.parts.iter().flat_map(|p| [(p.a_deg, p.after_um), (p.a_deg, p.before_um)]).collect();
    let bars = Series::new("workpieces", Mark::Bars, curves.e.len(), bars);
    Chart {
        x_label: "angle a of the surface's normal / °".to_owned(),
        y_label: "left along the normal e / µm".to_owned(),
        series: curves.e.iter().enumerate().map(line).chain([bars]).collect(),
        ..Chart::default()
    }
}

fn workpieces(curves: &Curves) -> Chart {
    let of = |value: fn(&reproduce_004::PartError) -> f64| {
        curves.parts.iter().map(|p| (p.part as f64, value(p))).collect::<Vec<_>>()
    };
    let count = curves.parts.len() as f64;
    Chart {
        x_label: "workpiece".to_owned(),
        y_label: "mean error along the normal / µm".to_owned(),
        series: vec![
            Series::new("before compensation", Mark::Dots, 1, of(|p| p.before_um)),
            Series::new("after", Mark::Dots, 0, of(|p| p.after_um)),
            Series::new("d = R1 − r", Mark::Dashed, 6, vec![(1.0, curves.d_um), (count, curves.d_um)]),
        ],
        x_labels: Some(curves.parts.len()),
        ..Chart::default()
    }
}
