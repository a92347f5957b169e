//! `shadowgauge reproduce 003`: the slender-shaft paper.

use std::path::PathBuf;

use super::reproduce;
use super::study_files::{ConfigText, StudyFolder};
use super::{CommandResult, Failure};
use crate::render::{BackendChoice, Renderer};
use crate::report::html::Page;
use crate::report::plot::{Chart, Mark, Series};
use crate::studies::optimize::OptimizeConfig;
use crate::studies::reproduce_003::{self, Inputs};
use crate::studies::reproduction::Row;

const INPUTS: &str = include_str!("../../configs/reproduce_003.toml");
const PROBLEM: &str = include_str!("../../configs/optimize_003.toml");

/// Parts of the paper and what their rows' ids start with.
const PARTS: [(&str, &[&str]); 6] = [
    ("Deflection and size error (eqs 1-3, section 3.3)", &["eq1 ", "eq2 ", "eq3 ", "beam."]),
    ("Forces (Tables 1 and 2)", &["table"]),
    ("Single factors (Figs 7-9)", &["fig7", "fig8", "fig9"]),
    ("Choice of cutting data (eqs 4-10)", &["eq4", "eq5", "eq6", "eq7", "eq8", "eq9", "eq10", "ga."]),
    (
        "PID (eqs 11-18) and stability",
        &["eq11", "eq12", "eq13", "eq14", "eq15", "eq16-17", "eq18", "stability."],
    ),
    ("Compensation (Fig. 11)", &["fig11."]),
];

/// Arguments of `reproduce 003`.
#[derive(Debug, clap::Args)]
pub struct Reproduce003Args {
    /// What the paper prints, in place of configs/reproduce_003.toml as the binary carries it.
    #[arg(long, value_name = "TOML")]
    inputs: Option<PathBuf>,
    /// The choice of cutting data, in place of configs/optimize_003.toml as the binary carries it.
    #[arg(long, value_name = "TOML")]
    problem: Option<PathBuf>,
    /// Leave out the rows of Fig. 11 that are measured on rendered frames.
    #[arg(long)]
    no_frames: bool,
    /// Where frames are rendered.
    #[arg(long, value_enum, default_value_t = BackendChoice::Auto)]
    backend: BackendChoice,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write report.html, rows.csv and plots into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Computes every row.
///
/// # Errors
/// Exit 2 for inputs that are refused, 3 for a device or a disk that fails.
pub fn run(args: &Reproduce003Args) -> CommandResult {
    let inputs_text = ConfigText::read_or(args.inputs.as_deref(), "configs/reproduce_003.toml", INPUTS)?;
    let problem_text = ConfigText::read_or(args.problem.as_deref(), "configs/optimize_003.toml", PROBLEM)?;
    let inputs: Inputs = inputs_text.parse()?;
    let problem: OptimizeConfig = problem_text.parse()?;
    problem.validate().map_err(|e| problem_text.refuse(e))?;
    let folder = args.out.as_deref().map(StudyFolder::claim).transpose()?;
    let renderer =
        (!args.no_frames).then(|| Renderer::new(args.backend)).transpose().map_err(Failure::fail)?;
    let rows = reproduce_003::run(&inputs, &problem, renderer.as_ref()).map_err(|e| inputs_text.refuse(e))?;
    if let Some(folder) = folder {
        write(&folder, &rows)?;
        folder.finish()?;
    }
    reproduce::print(&rows, args.json)
}

fn write(folder: &StudyFolder, rows: &[Row]) -> Result<(), Failure> {
    let mut page = Page::new("Reproduction: slender shaft, genetic algorithm and PID (Xue, Miao, Xue 2023)");
    page.text(
        "Every figure of the paper beside ours, computed now. \"Consistent\" needs an assumption or a wider limit, which the \
         reason names; a contradiction lies in the paper.",
    );
    let chart = fig_11(rows).to_svg().map_err(Failure::fail)?;
    page.figure(
        &chart,
        "Fig. 11: error after each pass, the paper's, the error-transfer plant's and the physical plant's.",
    );
    reproduce::tables(&mut page, rows, &PARTS);
    folder.write("fig11.svg", chart.as_bytes())?;
    folder.write("rows.csv", &super::study_files::csv_text(rows)?)?;
    folder.write("report.html", page.finish().as_bytes())
}

fn fig_11(rows: &[Row]) -> Chart {
    let passes = |prefix: &str, value: fn(&Row) -> Option<f64>| -> Vec<(f64, f64)> {
        (1..=4)
            .filter_map(|k| {
                let id = format!("{prefix}.pass{k}");
                let row = rows.iter().find(|row| row.id == id)?;
                Some((f64::from(k), 1e3 * value(row)?))
            })
            .collect()
    };
    let ours: fn(&Row) -> Option<f64> = |row| Some(row.ours);
    let paper: fn(&Row) -> Option<f64> = |row| row.paper;
    let mut series = vec![
        Series::new("paper, no control", Mark::Dots, 1, passes("fig11.uncompensated", paper)),
        Series::new("paper, PID", Mark::Dots, 0, passes("fig11.compensated", paper)),
        Series::new("transfer plant, no control", Mark::Dashed, 1, passes("fig11.uncompensated", ours)),
        Series::new("transfer plant, PID", Mark::Dashed, 0, passes("fig11.compensated", ours)),
        Series::new("physical plant, no control", Mark::LineDots, 4, passes("fig11.physical.none", ours)),
        Series::new("physical plant, PID", Mark::LineDots, 5, passes("fig11.physical.accumulated", ours)),
        Series::new("through frames, no control", Mark::LineDots, 2, passes("fig11.frames.none", ours)),
        Series::new("through frames, PID", Mark::LineDots, 3, passes("fig11.frames.pid", ours)),
    ];
    series.retain(|s| !s.points.is_empty());
    Chart {
        x_label: "pass".to_owned(),
        y_label: "error at 250 mm / µm of diameter".to_owned(),
        series,
        // Room for the legend above the last points.
        y_range: Some((-20.0, 620.0)),
        ..Chart::default()
    }
}
