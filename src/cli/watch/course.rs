//! How the readings of a session run in time: the last value, whether it holds now, trend, rate,
//! parts, and why none came.

use std::time::{Duration, Instant};

use crate::measurement::watch::{FrameValue, Invalid, Pace, Presence, Trend, TurnCover, Validity};
use crate::measurement::{Measurement, Settled};

/// A value with its U and the word of its judgement.
type LastValue = (f64, f64, &'static str);

/// What the frames so far amount to.
pub(super) struct Course {
    begun: Instant,
    pub(super) pace: Pace,
    pub(super) trend: Trend,
    pub(super) turns: TurnCover,
    pub(super) presence: Presence,
    pub(super) validity: Validity,
    last: Option<LastValue>,
    was_invalid: Option<&'static str>,
    /// Frames with a value.
    pub(super) measured: u64,
    /// Why the first frame was refused.
    first_refusal: Option<String>,
}

impl Course {
    /// A course that begins now; a reading is none of now from the age `stale` on.
    pub(super) fn new(stale: Duration) -> Self {
        Self {
            begun: Instant::now(),
            pace: Pace::default(),
            trend: Trend::default(),
            turns: TurnCover::default(),
            presence: Presence::default(),
            validity: Validity::new(stale.as_secs_f64()),
            last: None,
            was_invalid: None,
            measured: 0,
            first_refusal: None,
        }
    }

    /// Seconds since it began.
    pub(super) fn now_s(&self) -> f64 {
        self.begun.elapsed().as_secs_f64()
    }

    /// Whether nothing came for longer than `idle`.
    pub(super) fn is_idle(&self, idle: Option<Duration>) -> bool {
        let age_s = self.validity.age_s(self.now_s()).unwrap_or_else(|| self.now_s());
        idle.is_some_and(|idle| age_s > idle.as_secs_f64())
    }

    /// Keeps why a frame was refused, where it is the first.
    pub(super) fn note_refusal(&mut self, why: &str) {
        self.first_refusal.get_or_insert_with(|| why.to_owned());
    }

    /// Why no frame of the source `name` has a value; `None` where one has.
    pub(super) fn why_none_is_measured(&self, name: &str) -> Option<String> {
        let none = || format!("{name}: no frame came");
        (self.measured == 0).then(|| self.first_refusal.clone().unwrap_or_else(none))
    }

    /// Takes the value of a measured frame, or that it has none.
    pub(super) fn take_value(&mut self, t_s: f64, of: &Measurement, value: Option<FrameValue>) {
        let refusal = of.refusal.as_ref().map(|refusal| refusal.why.clone());
        let unsettled = of.settled.as_ref().and_then(Settled::why);
        refusal.iter().for_each(|why| self.note_refusal(why));
        self.validity.frame(t_s, refusal.map(Invalid::Refused).or(unsettled.map(Invalid::NotSettled)));
        self.last = value.map(|v| (v.value, v.expanded_u, v.word));
        let Some(value) = value else { return };
        self.measured += 1;
        if !self.presence.is_there() {
            self.trend.clear();
        }
        self.trend.push(t_s, value.value);
    }

    /// Why the reading does not hold, where that has changed since the last call.
    pub(super) fn newly_invalid<'a>(&mut self, invalid: Option<&'a Invalid>) -> Option<&'a Invalid> {
        let word = invalid.map(Invalid::word);
        let before = std::mem::replace(&mut self.was_invalid, word);
        invalid.filter(|_| word != before)
    }

    /// The reading of now, or why there is none.
    pub(super) fn reading<'a>(&self, invalid: Option<&'a Invalid>) -> Result<LastValue, &'a Invalid> {
        match (invalid, self.last) {
            (Some(invalid), _) => Err(invalid),
            (None, last) => last.ok_or(&Invalid::NoFrame),
        }
    }
}
