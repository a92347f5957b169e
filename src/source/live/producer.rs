//! What a kind of source implements: one frame after another, on a thread of its own.

use std::time::Duration;

use super::event::Remarks;
use super::metadata::LiveMeta;
use crate::frame::{CameraBinding, Frame};

/// A frame as its source made it.
#[derive(Debug)]
pub(crate) struct NewFrame {
    /// Pixels and metadata for the gauge.
    pub frame: Frame,
    /// When and where it was taken.
    pub meta: LiveMeta,
    /// What its file states.
    pub remarks: Remarks,
}

/// What a producer has.
#[derive(Debug)]
pub(crate) enum Produced {
    /// A whole frame. Numbers between it and the last one are lost.
    Frame(Box<NewFrame>),
    /// A frame that arrived in part or damaged: its number, and why.
    Incomplete(u64, String),
    /// Frames before this number that did not come will not come any more.
    Missing(u64),
    /// Nothing yet.
    Nothing,
    /// The source disappeared, and why; the next call looks for it again.
    Lost(String),
    /// There is no more; with the reason where the source failed.
    End(Option<String>),
}

/// A source behind its thread.
pub(crate) trait Producer: Send {
    /// Waits at most so long for the next thing. `spare` is the memory of an earlier frame, where
    /// there is one.
    fn produce(&mut self, spare: Option<Frame>, wait: Duration) -> Produced;

    /// Begins to deliver, again after [`Self::stop`] or an end: sequence numbers go on.
    fn start(&mut self) {}

    /// Ceases to deliver; a camera stops its acquisition.
    fn stop(&mut self) {}

    /// The camera that its frames are taken with, as it is set; `None` where there is none, or the
    /// source does not state it.
    fn camera(&self) -> Option<&CameraBinding> {
        None
    }
}
