//! `shadowgauge reproduce 000`: the least-squares paper.

use std::path::PathBuf;

use super::study_files::{StudyFolder, csv_text};
use super::{CommandResult, Failure, reproduce};
use crate::report::html::Page;
use crate::studies::reproduce_000::{self, Inputs};

/// Arguments of `reproduce 000`.
#[derive(Debug, clap::Args)]
pub struct Reproduce000Args {
    /// The six errors at x = 1/6 … 1, in units; by default those reconstructed from the paper's a and b.
    #[arg(long, value_name = "E", value_delimiter = ',', num_args = 1.., allow_negative_numbers = true)]
    errors: Vec<f64>,
    /// Unit of the errors, mm.
    #[arg(long, value_name = "MM", default_value_t = 0.01)]
    unit_mm: f64,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write rows.csv and report.html into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Computes every row.
///
/// # Errors
/// Exit 2 for inputs that are refused, 3 for a disk that fails.
pub fn run(args: &Reproduce000Args) -> CommandResult {
    let mut inputs = Inputs { unit_mm: args.unit_mm, ..Inputs::default() };
    if !args.errors.is_empty() {
        inputs.error.clone_from(&args.errors);
    }
    let rows = reproduce_000::run(&inputs).map_err(Failure::refuse)?;
    if let Some(out) = &args.out {
        let folder = StudyFolder::claim(out)?;
        let mut page =
            Page::new("Reproduction: least-squares compensation of a single shaft through macro variables");
        page.text(
            "Every figure of the paper beside ours, computed now. A contradiction lies in the paper; the reason says how.",
        );
        let parts: [(&str, &[&str]); 4] = [
            ("Errors after semi-finishing", &["table1."]),
            ("The line, equations 4-6", &["eq4.", "eq5.", "eq6."]),
            ("Macro variables, equations 7-10", &["eq7", "eq8.", "eq9.", "eq10."]),
            ("Experiment", &["experiment."]),
        ];
        reproduce::tables(&mut page, &rows, &parts);
        folder.write("rows.csv", &csv_text(&rows)?)?;
        folder.write("report.html", page.finish().as_bytes())?;
        folder.finish()?;
    }
    reproduce::print(&rows, args.json)
}
