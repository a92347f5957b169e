//! Studies over the stages: single factors, deflection, choice of cutting data, coverage,
//! reproductions of papers.
//!
//! In: a config of the study, a seed, a renderer where frames are drawn. Out: rows as serde types;
//! the command of the same name prints them and writes tables. `calibration` computes a
//! calibration from recorded or rendered frames, also for other commands; `reproduction` holds
//! rows and verdicts of a paper's figures; `sharding` splits studies of independent scenes between
//! processes. A new study is a file or folder here with the
//! computation, and a command in `cli/study` with its output.

pub(crate) mod calibration;
pub(crate) mod contamination;
pub(crate) mod contamination_plan;
pub(crate) mod controllers;
pub(crate) mod correlation;
pub(crate) mod coverage;
pub(crate) mod deflection;
pub(crate) mod deflection_line;
pub(crate) mod dirty_frames;
pub(crate) mod factor;
pub(crate) mod flanks;
pub(crate) mod golden_cases;
pub(crate) mod head;
pub(crate) mod in_process;
pub(crate) mod limb_fit;
pub(crate) mod limits;
pub(crate) mod line_camera;
pub(crate) mod machine;
pub(crate) mod machine_coverage;
pub(crate) mod machine_readings;
pub(crate) mod noses;
pub mod optimize;
pub(crate) mod parts;
pub(crate) mod reproduce_000;
pub(crate) mod reproduce_001;
pub(crate) mod reproduce_003;
pub(crate) mod reproduce_004;
pub(crate) mod reproduction;
pub(crate) mod sharding;
pub(crate) mod stability;
pub(crate) mod uncertainty;
pub(crate) mod washers;
pub(crate) mod worn_flanks;
pub(crate) mod worn_noses;
pub(crate) mod worn_tool;
