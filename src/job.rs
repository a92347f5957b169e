//! The settings of a job in two halves: the closed loop's and the simulation's.
//!
//! [`LoopJob`] is the loop's half, for any cell: the part and its passes, the scan, the masters,
//! the camera's data sheet (`FieldOfView`), the gauge, a probe, the controller, the machine that
//! the offsets go to. [`Job`] is a whole config file: the same tables, and those of the
//! simulation (shaft, camera, optics, light, sensor, motion, contamination, departures, process);
//! `Job::loop_job` takes the loop's half out of it. Each stage owns its settings; both check
//! conditions across stages (a shaft larger than the field, masters outside it, passes that do not
//! remove material). Errors name the key and the valid range.
//!
//! `part` (with `part_section`), `scan`, `nc_job`, `probe` and `follow` are tables and plans of the
//! loop; `stations` are a function of its part, `sections` make of a drawing a contour that can be
//! turned; `simulated` is the whole job, `run_tool` its tool with a worn nose, `machine` the
//! lathe's errors in a run, `drawn` what a picture of it needs, `workpiece` what the model-based
//! controller takes from it, `edge` and `gauge_settings` give the gauge the edge of the job's own
//! optics; `error` is what a check refuses. A new table of the loop is a field of both with a check
//! of its own, called in [`LoopJob::check`]; one of the simulation a field of [`Job`] alone.

#[cfg(feature = "render")]
mod drawn;
#[cfg(feature = "render")]
mod edge;
mod error;
mod field_of_view;
mod follow;
#[cfg(feature = "render")]
mod gauge_settings;
mod loop_job;
#[cfg(feature = "render")]
mod machine;
mod nc_job;
mod part;
#[cfg(feature = "render")]
mod part_facts;
mod part_section;
mod probe;
#[cfg(feature = "render")]
mod run_tool;
mod scan;
mod sections;
#[cfg(feature = "render")]
mod simulated;
mod stations;
#[cfg(feature = "render")]
mod workpiece;

pub use self::field_of_view::FieldOfView;
pub use self::loop_job::LoopJob;
pub use self::{
    nc_job::NcJob,
    part::Part,
    part_section::PartSection,
    scan::{Scan, ScanWhen, StockScan},
};
pub use crate::conformity::Tolerance;
#[cfg(feature = "render")]
pub(crate) use edge::NominalEdge;
#[cfg(feature = "render")]
pub(crate) use edge::sampled_edge;
#[cfg(feature = "render")]
pub(crate) use error::from_render;
#[cfg(feature = "render")]
pub use machine::RunMachine;
#[cfg(feature = "render")]
pub(crate) use machine::{HeadView, Lathe, MachineRow, ProbeRow};
#[cfg(feature = "render")]
pub(crate) use run_tool::CuttingTruth;
#[cfg(feature = "render")]
pub use run_tool::RunTool;
#[cfg(feature = "render")]
pub use simulated::Job;
