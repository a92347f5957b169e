//! What became of the frames that a source sent.

/// Counts of frames. Every number that a source sent is in exactly one of the first five; see
/// [`Self::accounted`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Counters {
    /// Frames given to the consumer.
    pub delivered: u64,
    /// Whole frames left out by the policy.
    pub dropped: u64,
    /// Frames that arrived in part or damaged; never measured.
    pub incomplete: u64,
    /// Frames that did not arrive.
    pub lost: u64,
    /// Whole frames that wait for the consumer.
    pub waiting: u64,
    /// Frames that came a second time, or after their successors: left out, beside the others.
    pub repeated: u64,
    /// Times that the source disappeared.
    pub disappeared: u64,
}

impl Counters {
    /// Frames that the source sent, as its sequence numbers show: every one is delivered, dropped,
    /// incomplete, lost or waiting.
    #[cfg_attr(not(test), allow(dead_code, reason = "the sum that every source is tested by"))]
    pub(crate) fn accounted(&self) -> u64 {
        self.delivered + self.dropped + self.incomplete + self.lost + self.waiting
    }
}
