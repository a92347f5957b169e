//! Live sources: frames as a camera delivers them, with what was lost between them.
//!
//! In: a [`Producer`] (a camera's client, a pipe, a folder, the simulator) that runs on a thread of
//! its own. Out: [`Event`]s by [`LiveSource`]: a frame on a pooled buffer, a gap with its sequence
//! numbers and reasons, a time-out, a source that disappeared, the end. From below: `gap`,
//! `counters`, `metadata` (clocks and provenance), `sequence` (ids of 16, 32 and 64 bits to one
//! number), `clock_map` (device to host), `pool` (bounded leases), `event` → `queue` (the policy
//! between producer and consumer) → `producer`, `source` (the thread) → `stored` (images of files
//! and pipes as a producer), `bound` (a producer with an encoder beside it), `windows` (two windows
//! of a producer's frames) and `taken` (a live source as frames to be decoded ahead). One more kind
//! of source is a file that implements `Producer`; it passes `tests/inside/live`.
#![cfg_attr(
    not(feature = "camera"),
    allow(dead_code, unused_imports, reason = "clocks, ids and chunks are those of cameras")
)]

mod bound;
mod clock_map;
mod counters;
mod event;
mod gap;
mod metadata;
mod pool;
mod producer;
mod queue;
mod sequence;
mod source;
mod stored;
mod taken;
mod windows;

pub(crate) use self::bound::{Binding, Bound, EncoderSamples, IndexTimes, SampleClock};
pub(crate) use self::clock_map::{ClockMap, ClockMapError, RoundTrip};
pub(crate) use self::counters::Counters;
pub(crate) use self::event::{Event, LiveFrame, Remarks};
pub(crate) use self::gap::Gap;
pub(crate) use self::metadata::{Clock, Known, LiveMeta, Provenance, Timestamp};
pub(crate) use self::pool::Lease;
pub(crate) use self::producer::{NewFrame, Produced, Producer};
pub(crate) use self::queue::Policy;
pub(crate) use self::sequence::{IdWidth, Unwrapper};
pub(crate) use self::source::{Live, LiveSettings, LiveSource};
pub(crate) use self::stored::StoredProducer;
pub(crate) use self::taken::taken;
pub(crate) use self::windows::{TwoWindows, Windowed};
