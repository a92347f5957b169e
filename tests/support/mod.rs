//! Helpers of several tests.

pub mod faulty_cell;
pub mod gauge_synth;
pub mod plant;
pub mod program;
pub mod render;
pub mod render_golden;
pub mod turned;
