//! Plots and HTML from what a run folder, a calibration or a study holds.

mod axis_report;
mod budget_words;
mod calibration_report;
mod error;
mod form_report;
pub mod html;
pub mod plot;
mod probe_report;
mod run_report;
mod sample;
mod shaft_report;
mod washers_report;

pub use budget_words::{BUDGET_HEADER, budget_rows};
pub use calibration_report::calibration_report;
pub use error::ReportError;
pub use run_report::{RunPage, RunView, run_report};
pub use washers_report::washers_page;
