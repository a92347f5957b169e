//! Studies over the stages: single factors, deflection, choice of cutting data, coverage,
//! reproductions of papers.
//!
//! In: a config of the study, a seed, a renderer where frames are drawn. Out: rows as serde types;
//! the command of the same name prints them and writes tables. [`calibration`] computes a
//! calibration from recorded or rendered frames, also for other commands; [`reproduction`] holds
//! rows and verdicts of a paper's figures. A new study is a file or folder here with the
//! computation, and a command in `cli/study` with its output.

pub mod calibration;
pub mod contamination;
pub mod controllers;
pub mod coverage;
pub mod deflection;
pub mod deflection_line;
pub mod dirty_frames;
pub mod factor;
pub mod golden_cases;
pub mod in_process;
pub mod limits;
pub mod line_camera;
pub mod optimize;
pub mod parts;
pub mod reproduce_000;
pub mod reproduce_003;
pub mod reproduction;
pub mod stability;
pub mod uncertainty;
pub mod washers;
