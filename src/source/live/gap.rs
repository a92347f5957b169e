//! Sequence numbers without a frame, and why.

use std::fmt;

/// A run of consecutive sequence numbers that the consumer gets no frame of. Its counts add up to
/// the length of the run, so that neighbouring gaps can be joined without loss.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Gap {
    /// First number without a frame.
    pub first: u64,
    /// Number after the last one without a frame.
    pub next: u64,
    /// Frames of which nothing arrived.
    pub lost: u64,
    /// Frames that arrived in part, or damaged.
    pub incomplete: u64,
    /// Frames that arrived whole and were left out, because the consumer was too slow.
    pub dropped: u64,
    /// The first reason in words, where there is one beyond the counts.
    pub why: Option<String>,
}

impl Gap {
    /// Frames that did not arrive, from `first` to before `next`.
    pub(super) fn lost(first: u64, next: u64) -> Self {
        Self { first, next, lost: next - first, ..Self::default() }
    }

    /// A frame that arrived in part.
    pub(super) fn incomplete(number: u64, why: String) -> Self {
        Self { first: number, next: number + 1, incomplete: 1, why: Some(why), ..Self::default() }
    }

    /// A whole frame that was left out.
    pub(super) fn dropped(number: u64) -> Self {
        Self { first: number, next: number + 1, dropped: 1, ..Self::default() }
    }

    /// Frames missing, at least 1.
    pub(crate) fn count(&self) -> u64 {
        self.next - self.first
    }

    /// Joins the gap that follows this one without a number between them.
    pub(super) fn join(&mut self, after: Self) {
        self.next = after.next;
        self.lost += after.lost;
        self.incomplete += after.incomplete;
        self.dropped += after.dropped;
        self.why = self.why.take().or(after.why);
    }
}

impl fmt::Display for Gap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.count() {
            1 => write!(f, "frame {}", self.first)?,
            _ => write!(f, "frames {} to {}", self.first, self.next - 1)?,
        }
        let counts = [
            (self.lost, "did not arrive"),
            (self.incomplete, "incomplete"),
            (self.dropped, "left out: the gauge was too slow"),
        ];
        let mut separator = ": ";
        for (count, what) in counts.into_iter().filter(|(count, _)| *count > 0) {
            write!(f, "{separator}{count} {what}")?;
            separator = ", ";
        }
        self.why.as_ref().map_or(Ok(()), |why| write!(f, " ({why})"))
    }
}
