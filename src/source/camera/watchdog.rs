//! When a camera that sends no frame is polled, and when it counts as gone.
//!
//! A client without a watchdog waits for ever: the control channel of a camera that is gone fails
//! only after retries of some seconds.

use std::time::{Duration, Instant};

/// Least silence before the camera is polled: with [`ANSWER`] waited for twice, a camera that is
/// gone is reported within 1 s.
const SILENCE: Duration = Duration::from_millis(400);
/// Periods without a frame after which the camera is polled: a single lost frame leaves two.
const PERIODS: u32 = 3;
/// Longest wait for an answer to a discovery: hundreds of times what it takes on a free link. With
/// 250 ms a camera that was silent on a loaded machine was reported after 1.00 s.
pub(super) const ANSWER: Duration = Duration::from_millis(200);
/// Silence of the stream, while the camera answers, that is reported: twenty times [`SILENCE`], so
/// that a head that is slow to take its first frame is not.
const BLOCKED: Duration = Duration::from_secs(8);

/// What is to be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Watch {
    /// Nothing: frames come, or it is too early.
    Quiet,
    /// The camera is to be polled.
    Ask,
    /// It answers and sends nothing: reported once per silence.
    Blocked,
}

/// When a camera last sent a frame or an answer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Watchdog {
    silence: Duration,
    blocked: Duration,
    framed: Instant,
    asked: Instant,
    has_stated: bool,
}

impl Watchdog {
    /// For a camera with this period, where it is known.
    pub(super) fn new(period: Option<Duration>, now: Instant) -> Self {
        let silence = period.map_or(SILENCE, |period| SILENCE.max(PERIODS * period));
        Self { silence, blocked: BLOCKED.max(20 * silence), framed: now, asked: now, has_stated: false }
    }

    /// A frame came, whole or not.
    pub(super) fn frame(&mut self, now: Instant) {
        (self.framed, self.asked, self.has_stated) = (now, now, false);
    }

    /// The camera answered, without a frame.
    pub(super) fn answered(&mut self, now: Instant) {
        self.asked = now;
    }

    /// What is to be done now.
    pub(super) fn look(&mut self, now: Instant) -> Watch {
        if now.duration_since(self.asked) >= self.silence {
            return Watch::Ask;
        }
        if !self.has_stated && now.duration_since(self.framed) >= self.blocked {
            self.has_stated = true;
            return Watch::Blocked;
        }
        Watch::Quiet
    }

    /// Time without a frame.
    pub(super) fn silent(&self, now: Instant) -> Duration {
        now.duration_since(self.framed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_silent_camera_is_asked_and_a_silent_stream_is_stated_once() {
        let start = Instant::now();
        let at = |ms: u64| start + Duration::from_millis(ms);
        let mut dog = Watchdog::new(Some(Duration::from_millis(20)), start);
        assert_eq!([100, 399, 400].map(|ms| dog.look(at(ms))), [Watch::Quiet, Watch::Quiet, Watch::Ask]);
        dog.frame(at(410));
        assert_eq!([500, 810].map(|ms| dog.look(at(ms))), [Watch::Quiet, Watch::Ask]);
        for ms in (810..8410).step_by(390) {
            dog.answered(at(ms));
        }
        assert_eq!(
            [8409, 8410, 8411].map(|ms| dog.look(at(ms))),
            [Watch::Quiet, Watch::Blocked, Watch::Quiet]
        );
        assert_eq!(dog.silent(at(8411)), Duration::from_millis(8001));
        let slow = Watchdog::new(Some(Duration::from_secs(2)), start);
        assert_eq!(slow.silence, Duration::from_secs(6), "a slow camera is given three periods");
    }
}
