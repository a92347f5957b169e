//! `shadowgauge reproduce 001`: the paper on the lathe as its own measuring machine.

use std::path::PathBuf;

use super::tables;
use crate::cli::failure::{CommandResult, Failure};
use crate::cli::input_output::{StudyFolder, csv_text};
use crate::report::html::Page;
use crate::studies::reproduce_001::{self, Inputs};
use crate::studies::reproduction::Row;

/// Arguments of `reproduce 001`.
#[derive(Debug, clap::Args)]
pub(crate) struct Reproduce001Args {
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write report.html and rows.csv into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Parts of the paper and the prefixes of their rows' ids.
const PARTS: [(&str, &[&str]); 5] = [
    ("The 21 errors and eqs 1 to 6", &["list.", "eq1.", "eq3.", "eq4.", "eq5.", "eq6."]),
    ("Nets and training samples", &["netB.", "samples.", "models."]),
    ("Experiments", &["straightness.", "cylindricity.", "flatness.", "self.", "scatter.", "temperature."]),
    ("The spiral on the face", &["spiral."]),
    ("The spindle, which the paper leaves in", &["spindle."]),
];

/// Computes every row.
///
/// # Errors
/// Exit 3 for a disk that fails.
pub(crate) fn run(args: &Reproduce001Args) -> CommandResult {
    let rows = reproduce_001::run(&Inputs::default()).map_err(Failure::refuse)?;
    let folder = StudyFolder::claim(args.out.as_deref())?;
    StudyFolder::fill(folder, |folder| write(folder, &rows))?;
    tables::print(&rows, args.json)
}

fn write(folder: &StudyFolder, rows: &[Row]) -> Result<(), Failure> {
    let mut page = Page::new("Reproduction: the lathe as its own measuring machine");
    page.text(tables::VERDICTS);
    page.text(&tables::summary(rows));
    tables::tables(&mut page, rows, &PARTS);
    folder.write("rows.csv", &csv_text(rows)?)?;
    folder.write("report.html", page.finish().as_bytes())
}
