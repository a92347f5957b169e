//! Plots and HTML pages of a run folder, a calibration or a study.
//!
//! In: a [`RunView`] (job, folder, sample), a calibration, frames or rings measured. Out: one
//! self-contained page and the files beside it. [`html`] makes pages, [`plot`] charts (`marks`:
//! their series, `picture`: frames), in the `colours` of both schemes; a report is a file of
//! sections, each a function of a page and its data (`shaft_report`, `form_report`, `axis_report`,
//! `machine_section`, `probe_report`, `sample`, `budget_words`, for `measure_report`
//! `measured_frames`, `measured_values`, `measured_setup`, `measured_charts`, `measured_series` and
//! `reason_words`, for `head_report` `head_rows`). A new section is a file and one call in the
//! report it belongs to.

mod axis_report;
mod budget_words;
mod calibration_report;
mod colours;
mod error;
mod form_report;
mod head_report;
pub(crate) mod head_rows;
pub(crate) mod html;
mod machine_report;
mod machine_section;
mod marks;
pub(crate) mod measure_report;
mod measured_charts;
mod measured_frames;
mod measured_series;
mod measured_setup;
mod measured_values;
mod optics_report;
mod picture;
pub(crate) mod plot;
mod probe_report;
mod reason_words;
mod run_report;
mod sample;
mod section_report;
mod shaft_report;
mod washers_report;

pub(crate) use calibration_report::calibration_report;
pub(crate) use head_report::head_page;
pub(crate) use machine_report::{MachinePage, machine_page};
pub(crate) use optics_report::optics_page;
pub(crate) use run_report::{RunView, run_report};
pub(crate) use washers_report::washers_page;
