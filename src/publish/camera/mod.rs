//! The camera without a network: its memory, who is in control, what is acquired.
//!
//! In: datagrams with the address they come from and the time of the head's clock. Out: answers,
//! and [`Task`]s: the next frame to take, the next pass to cut. `memory` holds the bytes, `clients`
//! control and repeated commands, `acquisition` when frames are due, `settings` what the registers
//! state of a stream and its faults, `camera` joins them; `writes` is what a write sets off. Time
//! is a number here, so that tests need not wait. What a register does besides being kept is an arm
//! in `writes`.

mod acquisition;
#[allow(clippy::module_inception, reason = "the file of the folder's main type")]
mod camera;
mod clients;
mod memory;
mod settings;
mod writes;

pub(crate) use acquisition::{FrameTask, Task};
pub(crate) use camera::{Action, Camera, Reply};
pub(crate) use settings::{Faults, StreamSettings};
