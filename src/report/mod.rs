//! Plots and HTML pages of a run folder, a calibration or a study.
//!
//! In: a [`RunView`] (job, folder, sample), a calibration, rings measured. Out: one self-contained
//! page and the files beside it. [`html`] makes pages, [`plot`] charts; a report is a file of
//! sections, each a function of a page and its data (`shaft_report`, `form_report`, `axis_report`,
//! `probe_report`, `sample`, `budget_words`). A new section is a file and one call in the report it
//! belongs to.

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
