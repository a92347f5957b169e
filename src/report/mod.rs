//! Plots and HTML from what a run folder, a calibration or a study holds.

mod calibration_report;
mod form_report;
pub mod html;
pub mod plot;
mod run_report;
mod sample;
mod washers_report;

pub use calibration_report::calibration_report;
pub use run_report::{ReportError, RunPage, RunView, run_report};
pub use washers_report::washers_page;

use crate::gauge::budget::Budget;

/// Columns of [`budget_rows`].
pub const BUDGET_HEADER: [&str; 6] = ["source", "input", "distribution", "share", "u / µm", "% of u²"];

/// The rows of a budget, largest first.
pub fn budget_rows(budget: &Budget) -> Vec<Vec<String>> {
    let total = budget.u_mm().powi(2);
    let mut rows: Vec<_> = budget.contributions.iter().collect();
    rows.sort_by(|a, b| b.u_mm.total_cmp(&a.u_mm));
    rows.into_iter()
        .map(|c| {
            vec![
                c.source.clone(),
                c.input.clone(),
                c.shape.as_str().to_owned(),
                format!("{:?}", c.share).to_lowercase(),
                format!("{:.4}", 1e3 * c.u_mm),
                format!("{:.2}", 1e2 * c.u_mm * c.u_mm / total),
            ]
        })
        .collect()
}
