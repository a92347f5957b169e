//! The events of a source, measured one after another.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::on_alarm::OnAlarm;
use super::shown::{Missed, Now, Shown, ShownFrame};
use crate::cli::measure::frames::{FrameChecks, StatedOf};
use crate::cli::terminal::output;
use crate::frame::Frame;
use crate::gauge::stated::stated;
use crate::measurement::watch::{
    Alarm, FrameValue, Invalid, Pace, PartValue, Presence, Seen, Trend, Validity,
};
use crate::measurement::{Measurement, Stream};
use crate::profile::Reason;
use crate::source::host_t_ns;
use crate::source::live::{Counters, Event, Gap, Lease, LiveFrame, LiveMeta, LiveSource, Remarks};

/// Longest wait for a frame before age and Ctrl-C are looked at: ten looks a second are what a
/// person takes for at once.
const LOOK: Duration = Duration::from_millis(100);
/// Coverage factor of values in pixels, whose freedom is not stated.
const K: f64 = 2.0;

/// What a session is given.
#[derive(Debug)]
pub(super) struct SessionSettings {
    /// Time without a frame that ends it.
    pub(super) idle: Option<Duration>,
    /// Age from which a reading is none of now.
    pub(super) stale: Duration,
    /// Name of the source in messages.
    pub(super) name: String,
}

/// How a session ended.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Ended {
    /// The source ended, or was not wanted any more.
    Done,
    /// The source failed, and why.
    Failed(String),
    /// No frame could be measured, and why the first one could not.
    Unmeasured(String),
}

/// A source while it is watched.
pub(super) struct Session<'a> {
    stream: Stream,
    checks: FrameChecks<'a>,
    shown: Shown,
    settings: SessionSettings,
    on_alarm: OnAlarm,
    begun: Instant,
    pace: Pace,
    trend: Trend,
    presence: Presence,
    validity: Validity,
    alarm: Alarm,
    missed: Missed,
    /// The last value with its U and the word of its judgement.
    last: Option<(f64, f64, &'static str)>,
    was_invalid: Option<&'static str>,
    measured: u64,
    /// Why the first frame was refused.
    first_refusal: Option<String>,
}

impl<'a> Session<'a> {
    /// A session that begins now.
    pub(super) fn new(
        stream: Stream,
        checks: FrameChecks<'a>,
        shown: Shown,
        (settings, on_alarm): (SessionSettings, OnAlarm),
    ) -> Self {
        let validity = Validity::new(settings.stale.as_secs_f64());
        Self {
            stream,
            checks,
            shown,
            settings,
            on_alarm,
            begun: Instant::now(),
            pace: Pace::default(),
            trend: Trend::default(),
            presence: Presence::default(),
            validity,
            alarm: Alarm::default(),
            missed: Missed::default(),
            last: None,
            was_invalid: None,
            measured: 0,
            first_refusal: None,
        }
    }

    fn now_s(&self) -> f64 {
        self.begun.elapsed().as_secs_f64()
    }

    /// Watches a source to its end, to Ctrl-C, or until nothing comes any more.
    pub(super) fn watch(&mut self, live: &mut dyn LiveSource, stop: &AtomicBool) -> Ended {
        let is_wanted = || !stop.load(Ordering::Relaxed) && !output::has_failed();
        let mut failure = None;
        while is_wanted() && !self.is_idle() {
            match live.next_event(LOOK) {
                Event::Frame(frame) => self.frame(*frame),
                Event::Gap(gap) => self.gap(&gap),
                Event::Timeout => {}
                Event::Lost(why) => self.lost(why),
                Event::End(why) => {
                    failure = why;
                    break;
                }
            }
            self.look(&live.counters());
        }
        match (failure, is_wanted() && self.measured == 0) {
            (Some(why), _) => Ended::Failed(why),
            (None, true) => {
                let none = || format!("{}: no frame came", self.settings.name);
                Ended::Unmeasured(self.first_refusal.clone().unwrap_or_else(none))
            }
            (None, false) => Ended::Done,
        }
    }

    /// The part that is there still, and the counts; whether the alarm was raised.
    pub(super) fn finish(&mut self, counters: &Counters) -> bool {
        if let Some(part) = self.presence.end() {
            self.part(part);
        }
        self.on_alarm.finish();
        self.shown.end(counters, [self.measured, self.presence.parts()], &self.pace);
        self.alarm.cause().is_some()
    }

    fn is_idle(&self) -> bool {
        let age_s = self.validity.age_s(self.now_s()).unwrap_or_else(|| self.now_s());
        self.settings.idle.is_some_and(|idle| age_s > idle.as_secs_f64())
    }

    // ---- events

    fn frame(&mut self, frame: LiveFrame) {
        let LiveFrame { lease: Lease { frame, slot }, meta, remarks } = frame;
        remarks.notices.iter().for_each(|notice| tracing::warn!("{notice}"));
        if let Some(frame) = self.measure(frame, &meta, &remarks) {
            slot.give_back(frame);
        }
        let t_s = self.now_s();
        let latency_ms = meta.host_t.map(|t| host_t_ns().saturating_sub(t.t_ns) as f64 * 1e-6);
        self.pace.push(t_s, latency_ms);
        let (value, seen) = seen(self.stream.measurement(), meta.sequence);
        self.take_value(t_s, value);
        self.print(&meta, latency_ms);
        if let Some(part) = self.presence.push(seen) {
            self.part(part);
        }
    }

    /// Measures a frame, or counts why it cannot be; gives it back where its memory is whole.
    fn measure(&mut self, frame: Frame, meta: &LiveMeta, remarks: &Remarks) -> Option<Frame> {
        let number = format!("{:06}", meta.sequence);
        let stem = if remarks.stem.is_empty() { &number } else { &remarks.stem };
        let of = StatedOf { stem, scale: remarks.scale.as_ref(), changed: &remarks.changed };
        let checked = self.checks.check(of, &frame);
        match checked.and_then(|()| self.stream.prepared(stem, frame).map_err(|e| e.to_string())) {
            Ok(frame) => {
                // What a refused frame is refused for stands in its measurement.
                let _ = self.stream.push_prepared(stem, &frame.meta, &frame.view());
                Some(frame)
            }
            Err(why) => {
                self.stream.push_unreadable(stem, why);
                None
            }
        }
    }

    /// The value of the frame that was measured last, or that it has none.
    fn take_value(&mut self, t_s: f64, value: Option<FrameValue>) {
        let measurement = self.stream.measurement();
        let refusal = measurement.refusal.as_ref().map(|refusal| refusal.why.clone());
        let cause = value.filter(|v| v.severity > 1).map(|v| {
            let [d, u] = stated(v.value, v.expanded_u);
            format!("frame {}: {} at {d} mm, U {u} mm", measurement.frame, v.word)
        });
        if let (Some(why), None) = (&refusal, &self.first_refusal) {
            self.first_refusal = Some(why.clone());
        }
        self.validity.frame(t_s, refusal);
        self.last = value.map(|v| (v.value, v.expanded_u, v.word));
        if let Some(value) = value {
            self.measured += 1;
            if !self.presence.is_there() {
                self.trend.clear();
            }
            self.trend.push(t_s, value.value);
        }
        if let Some(cause) = cause {
            self.raise(&cause);
        }
    }

    fn print(&mut self, meta: &LiveMeta, latency_ms: Option<f64>) {
        let missed = std::mem::take(&mut self.missed);
        let (slope, is_alarmed) = (self.trend.slope(), self.alarm.cause().is_some());
        let measurement = self.stream.measurement();
        self.shown.frame(&ShownFrame { measurement, meta, missed, latency_ms, slope, is_alarmed });
    }

    fn gap(&mut self, gap: &Gap) {
        self.missed.lost += gap.lost;
        self.missed.incomplete += gap.incomplete;
        self.missed.dropped += gap.dropped;
        if let (Some(why), None) = (&gap.why, &self.first_refusal) {
            self.first_refusal = Some(why.clone());
        }
        self.shown.gap(gap);
    }

    fn lost(&mut self, why: String) {
        self.raise(&format!("{} is gone: {why}", self.settings.name));
        self.validity.lost(why);
    }

    fn part(&mut self, part: PartValue) {
        self.shown.part(&part);
        if part.severity > 0 {
            let word = if part.word.is_empty() { "not proven" } else { part.word };
            self.raise(&format!("part {}: {word}", part.number));
        }
    }

    fn raise(&mut self, cause: &str) {
        if self.alarm.raise(|| cause.to_owned()) {
            self.shown.alarm(cause);
            self.on_alarm.start(cause);
        }
    }

    /// Shows what is now; a reading that has become invalid once.
    fn look(&mut self, counters: &Counters) {
        let invalid = self.validity.invalid(self.now_s());
        let word = invalid.as_ref().map(Invalid::word);
        if let Some(invalid) = invalid.as_ref().filter(|_| word != self.was_invalid) {
            // A refused frame has a line of its own, with the reason.
            if !matches!(invalid, Invalid::Refused(_) | Invalid::NoFrame) {
                self.shown.invalid(invalid);
            }
        }
        self.was_invalid = word;
        let reading = match (&invalid, self.last) {
            (None, Some(last)) => Ok(last),
            (Some(invalid), _) => Err(invalid),
            (None, None) => Err(&Invalid::NoFrame),
        };
        self.shown.now(&Now {
            reading,
            slope: self.trend.slope(),
            pace: &self.pace,
            counters,
            parts: self.presence.parts(),
            alarm: self.alarm.cause(),
        });
    }
}

/// The value of a measured frame, and whether a part is in it.
fn seen(measurement: &Measurement, sequence: u64) -> (Option<FrameValue>, Seen) {
    let millimetres = measurement.diameter.as_ref().map(|d| (d.diameter.d_mm, d.expanded_u_mm));
    let pixels = measurement.largest.as_ref().map(|l| (l.diameter_px, K * l.u_px));
    if let Some(refusal) = &measurement.refusal {
        let is_empty = matches!(refusal.reason, Reason::NoEdge | Reason::LowContrast);
        return (None, if is_empty { Seen::Empty } else { Seen::Unclear });
    }
    let value = millimetres.or(pixels).filter(|(value, _)| value.is_finite());
    let Some((value, expanded_u)) = value else { return (None, Seen::Unclear) };
    let (severity, word) = (measurement.judgement.severity(), measurement.judgement.word());
    let value = FrameValue { sequence, value, expanded_u, severity, word };
    (Some(value), Seen::Part(value))
}
