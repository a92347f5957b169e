//! Studies over the stages: single factors, deflection, choice of cutting data, reproductions of papers.

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
pub mod line_camera;
pub mod optimize;
pub mod parts;
pub mod reproduce_000;
pub mod reproduce_003;
pub mod reproduction;
pub mod stability;
pub mod uncertainty;
pub mod washers;
