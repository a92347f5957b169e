//! The turning cell: cuts a pass, shows the part to the camera, touches it. The simulated one joins
//! process and render.
//!
//! In: plans of passes, scans and touches. Out: frames, touches, and for comparison only what is
//! true of the part. [`TurningCell`] and [`FollowedCut`] are what the closed loop needs of a lathe;
//! a real one implements them. `simulated` holds the state of the simulated one, `operations` what
//! it does, `in_process` a pass with the gauge behind the tool, `true_probe` its touch probe. A new
//! ability of a cell is a method of the trait with a refusal as its default.

mod in_process;
mod operations;
mod seen_burst;
mod simulated;
mod true_probe;
mod turning_cell;

pub use simulated::{SimulatedCell, base_form};
pub use turning_cell::{CellError, FollowedCut, SeenStation, TrueAxis, TurningCell};
