//! A controller that runs elsewhere, behind one line of JSON each way a pass.
//!
//! In: a stream of bytes to a program and back (pipes of a process, a socket, memory), the
//! [`PartFacts`] and the settings of control. Out: a [`Controller`](super::Controller), guarded as
//! the others are: the program's offsets pass the same checks before they are released.
//!
//! `facts` and `messages` are the lines to the program, `reply` a line from it, `conversation` both
//! over the stream, `answered` the law that proposes what was replied, `error` what a program can
//! do wrong, `program_controller` the controller. Processes are started elsewhere. A new key of a
//! message is a field in `messages`; one that programs must heed, or a key that is gone, is a new
//! [`PROTOCOL_VERSION`].

mod answered;
mod conversation;
mod error;
mod facts;
mod messages;
mod program_controller;
mod reply;

pub use error::{Fault, ProgramError};
pub(crate) use facts::PartFacts;
#[cfg(test)]
pub(crate) use messages::PROTOCOL_VERSION;
pub(crate) use program_controller::ProgramController;
