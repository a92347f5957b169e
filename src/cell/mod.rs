//! The turning cell: cuts a pass, takes frames of the part, touches it with a probe. The simulated
//! cell joins process and renderer.
//!
//! In: plans of passes, scans and touches. Out: frames, touches, and, for comparison only, true
//! values of the part. [`TurningCell`] and `FollowedCut` are the interface between the closed loop
//! and a lathe; an adapter to a real lathe implements them. `simulated` holds the state of the
//! simulated cell, `operations` its commands, `on_order` its single frames, `in_process` a pass
//! with the gauge behind the tool, `moved_head` the head by the errors of a lathe, `true_probe` its
//! touch probe; `drawn_scan` is the scan of a shaft that is drawn, not turned, and `simulated_head`
//! a live source of its frames; `recorded` is a cell of frames that were recorded, `wire` one whose
//! process and renderer are another program. A new ability of a cell is a method of the trait with
//! an error as its default.

#[cfg(feature = "render")]
mod drawn_scan;
#[cfg(feature = "render")]
mod in_process;
#[cfg(feature = "render")]
mod moved_head;
#[cfg(feature = "render")]
mod on_order;
#[cfg(feature = "render")]
mod operations;
#[cfg(feature = "render")]
mod recorded;
#[cfg(feature = "render")]
mod seen_burst;
#[cfg(feature = "render")]
mod simulated;
#[cfg(feature = "render")]
mod simulated_head;
#[cfg(feature = "render")]
mod true_probe;
mod turning_cell;
#[cfg(all(feature = "render", feature = "camera"))]
pub(crate) mod wire;

#[cfg(feature = "render")]
pub use drawn_scan::{drawn_scene, scan_request};
#[cfg(feature = "render")]
pub(crate) use recorded::RecordedCell;
#[cfg(feature = "render")]
pub use simulated::SimulatedCell;
#[cfg(feature = "render")]
pub(crate) use simulated::{base_form, frame_of_pass};
#[cfg(feature = "render")]
pub(crate) use simulated_head::{HeadPace, SimulatedHead};
pub use turning_cell::{CellError, FollowedCut, SeenStation, TrueAxis, TurningCell};
