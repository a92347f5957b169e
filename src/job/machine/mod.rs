//! The lathe of a run with its geometric errors: the `[machine]` table.
//!
//! In: a machine of [`crate::machine`] by its file or stated in the config, the job that runs on
//! it. Out: a [`Lathe`], which displaces the tool's path (with the control's own compensation where
//! `compensate` asks for it), the pose of the head before the part at any field ([`HeadView`]), and
//! what both amount to at the stations ([`MachineRow`]), for comparison only. `displacement_probe`
//! is a second head; `reading_correction` is what the instrument is given of the head's place, from
//! the control's table alone; `turn_harmonics` takes what the spindle's errors do over a turn apart
//! into lobes. One more thing that rides on the machine is a method of `Lathe` with its station.

mod contribution;
mod displacement_probe;
mod head_view;
mod lathe;
mod reading_correction;
mod run_machine;
mod run_settings;
mod turn_harmonics;

pub(crate) use contribution::MachineRow;
pub(crate) use displacement_probe::{ProbeRow, TruePlace};
pub(crate) use head_view::HeadView;
pub(crate) use lathe::Lathe;
pub(super) use run_machine::OnMachine;
pub use run_settings::RunMachine;
