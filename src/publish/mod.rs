//! The simulated head as a GigE Vision camera (AIA GigE Vision 2.2, GenICam, SFNC 2.7), by hand on
//! `std::net`.
//!
//! In: a checked job and an address. Out: datagrams, until it is ended. `gvcp`, `gvsp` and
//! `genicam` are the protocol: commands, streams, features with their registers and XML; they hold
//! no state and import nothing of ours but the vocabulary of frames. `head` is what a camera asks
//! of the head behind it, `camera` its state without a network, `server` the threads and sockets,
//! `simulated` the head of a job, by process and renderer. One more head is an implementation of
//! `FrameMaker`, one more feature a line in `genicam/features.rs`.

pub(crate) mod camera;
pub(crate) mod genicam;
pub(crate) mod gvcp;
pub(crate) mod gvsp;
pub(crate) mod head;
pub(crate) mod server;
pub(crate) mod simulated;

pub(crate) use camera::Camera;
pub(crate) use genicam::DataSheet;
pub(crate) use gvcp::PORT;
pub(crate) use server::{BindError, Sockets, serve};
pub(crate) use simulated::SimulatedHead;
