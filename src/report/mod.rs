//! Plots and HTML from what a run folder holds.

pub mod html;
pub mod plot;
mod run_report;
mod sample;

pub use run_report::{ReportError, RunPage, RunView, run_report};
