//! When frames are due: a free run by its rate, or trigger by trigger.

use std::collections::VecDeque;

use super::settings::StreamSettings;
use crate::publish::head::{FrameOrder, PassOrder};

/// What the head does next.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Task {
    /// Take a frame and send it.
    Frame(Box<FrameTask>),
    /// Cut a pass.
    Cut(PassOrder),
}

/// A frame to take and how to send it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FrameTask {
    /// The frame.
    pub order: FrameOrder,
    /// How to send it.
    pub stream: StreamSettings,
    /// Time from which it may be sent, ns.
    pub due_ns: u64,
    /// The acquisition it belongs to.
    pub acquisition: u64,
    /// The opening of the stream it belongs to.
    pub channel: u64,
}

/// Triggers that wait for their frame.
const MOST_TRIGGERS: usize = 16;

/// An acquisition under way.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Acquisition {
    /// Frames that are still to come; `None` without end.
    pub remaining: Option<u64>,
    triggered: bool,
    triggers: VecDeque<u64>,
    started_ns: u64,
    /// Number of the next frame.
    number: u64,
    /// Time of the next frame of a free run as the rate has it, and as it can be met.
    nominal_ns: u64,
    late_ns: u64,
}

impl Acquisition {
    /// An acquisition that starts now.
    pub(crate) fn new(now_ns: u64, remaining: Option<u64>, triggered: bool) -> Self {
        let triggers = VecDeque::new();
        Self { remaining, triggered, triggers, started_ns: now_ns, number: 0, nominal_ns: 0, late_ns: 0 }
    }

    /// Queues a trigger; `false` where it makes no frame.
    pub(crate) fn trigger(&mut self, now_ns: u64) -> bool {
        let takes = self.triggered && self.triggers.len() < MOST_TRIGGERS;
        if takes {
            self.triggers.push_back(now_ns);
        }
        takes
    }

    /// Number, scene time since the start, and due time of the next frame, ns; `None` where a
    /// trigger is awaited or all frames were taken. A free run that falls behind by more than a
    /// period goes on from now: no burst follows, and scene time keeps the nominal period.
    pub(crate) fn next(&mut self, now_ns: u64, period_ns: u64) -> Option<(u64, u64, u64)> {
        if self.remaining == Some(0) {
            return None;
        }
        let (scene_ns, due_ns) = if self.triggered {
            let at_ns = self.triggers.pop_front()?;
            (at_ns - self.started_ns.min(at_ns), at_ns)
        } else {
            let scene_ns = self.nominal_ns;
            self.nominal_ns += period_ns;
            let due_ns = self.started_ns + scene_ns + self.late_ns;
            if due_ns + period_ns < now_ns {
                self.late_ns += now_ns - due_ns;
            }
            (scene_ns, due_ns.max(now_ns.saturating_sub(period_ns)))
        };
        let number = self.number;
        self.number += 1;
        self.remaining = self.remaining.map(|left| left - 1);
        Some((number, scene_ns, due_ns))
    }

    /// Time since the start, ns.
    pub(crate) fn elapsed_ns(&self, now_ns: u64) -> u64 {
        now_ns.saturating_sub(self.started_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_free_run_keeps_its_rate_and_slips_where_it_cannot() {
        let mut run = Acquisition::new(1000, None, false);
        let due: Vec<u64> = (0..4).map(|_| run.next(1000, 10).unwrap().2).collect();
        assert_eq!(due, [1000, 1010, 1020, 1030], "frames are taken ahead of their time");
        // a second late: the next frames follow at their rate, the scene has lost nothing
        let late: Vec<_> = [2000, 2000, 2010].map(|now| run.next(now, 10).unwrap()).to_vec();
        assert_eq!(late, [(4, 40, 1990), (5, 50, 2010), (6, 60, 2020)]);
    }

    #[test]
    fn triggers_are_taken_in_order_and_too_many_are_refused() {
        let mut run = Acquisition::new(100, Some(2), true);
        assert_eq!(run.next(100, 10), None);
        assert!(run.trigger(150) && run.trigger(170) && run.trigger(180));
        assert_eq!(run.next(200, 10), Some((0, 50, 150)));
        assert_eq!(run.next(200, 10), Some((1, 70, 170)));
        assert_eq!(run.next(200, 10), None, "two frames were asked for");
        let mut full = Acquisition::new(0, None, true);
        assert_eq!((0..40).filter(|k| full.trigger(*k)).count(), MOST_TRIGGERS);
        assert!(!Acquisition::new(0, None, false).trigger(1), "a free run takes no trigger");
    }
}
