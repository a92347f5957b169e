//! GVCP, the control protocol of GigE Vision (AIA GigE Vision 2.2, chapters 13 to 19): datagrams on
//! UDP port 3956, every number big-endian.
//!
//! In: a datagram. Out: a [`Request`], or a [`Refusal`] with the status that answers it; and from a
//! status and a payload the datagram of an answer. Nothing is kept, nothing is executed, a datagram
//! of any content is parsed or refused without a panic and with memory bounded by the 548 bytes
//! that the protocol allows. `status` holds the status codes, `request` what a client sends,
//! `answer` what a device answers. One more command is a variant of [`Command`] with its arm in
//! `request`.

mod answer;
mod request;
mod status;

pub(crate) use answer::{Answer, answer};
pub(crate) use request::{Command, Refusal, Request, Resend, parse};
pub(crate) use status::Status;

/// UDP port on which a device takes commands.
pub(crate) const PORT: u16 = 3956;
