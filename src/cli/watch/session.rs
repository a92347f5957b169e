//! The events of a source, measured one after another.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::course::Course;
use super::frame_value::{alarm_of, diameters_along, is_empty, is_settled, seen};
use super::live_conditions::TakenConditions;
use super::picture::{PictureScale, Pictured};
use super::session_settings::{Beside, SessionSettings};
use super::setup_page::PageOf;
use super::shown::{Missed, Now, Shown, ShownFrame};
use crate::cli::failure::Failure;
use crate::cli::measure::frames::{FrameChecks, StatedOf};
use crate::cli::terminal::output;
use crate::frame::Frame;
use crate::measurement::Stream;
use crate::measurement::watch::{Alarm, Invalid, PartValue, Turn};
use crate::source::host_t_ns;
use crate::source::live::{Counters, Event, Gap, Lease, LiveFrame, LiveMeta, LiveSource, Remarks};

/// Longest wait for a frame before age and Ctrl-C are looked at: ten looks a second are what a
/// person takes for at once.
const LOOK: Duration = Duration::from_millis(100);

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
    beside: Beside,
    /// Conditions of the last frame.
    taken: TakenConditions,
    course: Course,
    alarm: Alarm,
    /// Frames that are lacking before the next one.
    missed: Missed,
}

impl<'a> Session<'a> {
    /// A session that begins now.
    pub(super) fn new(
        stream: Stream,
        checks: FrameChecks<'a>,
        shown: Shown,
        settings: SessionSettings,
        beside: Beside,
    ) -> Self {
        let course = Course::new(settings.stale);
        Self {
            stream,
            checks,
            shown,
            settings,
            beside,
            taken: TakenConditions::default(),
            course,
            alarm: Alarm::default(),
            missed: Missed::default(),
        }
    }

    /// Watches a source to its end, to Ctrl-C, or until nothing comes any more.
    pub(super) fn watch(&mut self, live: &mut dyn LiveSource, stop: &AtomicBool) -> Ended {
        let is_wanted = || !stop.load(Ordering::Relaxed) && !output::has_failed();
        let mut failure = None;
        while is_wanted() && !self.course.is_idle(self.settings.idle) {
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
        // Who sets a gauge up may have no frame that can be measured yet.
        let why_none = || self.course.why_none_is_measured(&self.settings.name);
        let none = if is_wanted() && self.beside.setup.is_none() { why_none() } else { None };
        match (failure, none) {
            (Some(why), _) => Ended::Failed(why),
            (None, Some(why)) => Ended::Unmeasured(why),
            (None, None) => Ended::Done,
        }
    }

    /// The part that is there still, and the counts; whether the alarm was raised.
    pub(super) fn finish(&mut self, counters: &Counters) -> bool {
        if let Some(part) = self.course.presence.end() {
            self.part(part);
        }
        self.beside.on_alarm.finish();
        if let Some(page) = &self.beside.setup {
            page.finish();
        }
        let Course { measured, presence, pace, .. } = &self.course;
        self.shown.end(counters, [*measured, presence.parts()], pace);
        self.alarm.cause().is_some()
    }

    /// Waits until everything that is saved is written.
    ///
    /// # Errors
    /// Where the disk refused.
    pub(super) fn end_saving(self) -> Result<(), Failure> {
        self.shown.end_saving()
    }

    // ---- events

    fn frame(&mut self, frame: LiveFrame) {
        let LiveFrame { lease: Lease { frame, slot }, meta, remarks } = frame;
        let sweep_deg = frame.meta.sweep_deg;
        remarks.notices.iter().for_each(|notice| tracing::warn!("{notice}"));
        if !self.course.presence.is_there() {
            // Until a part is there it may be another one.
            self.stream.restart_settling();
        }
        let raw = (self.settings.corrects && self.shown.saves_frames()).then(|| frame.clone());
        let measured = self.measure(frame, &meta, &remarks);
        let t_s = self.course.now_s();
        self.set_up(t_s, measured.as_ref(), &meta);
        self.picture(t_s, measured.as_ref(), meta.sequence);
        let saved = self.save(meta.sequence, || raw.or_else(|| measured.clone()));
        if let Some(frame) = measured {
            slot.give_back(frame);
        }
        let latency_ms = meta.host_t.map(|t| host_t_ns().saturating_sub(t.t_ns) as f64 * 1e-6);
        self.course.pace.push(t_s, latency_ms);
        let measurement = self.stream.measurement();
        let (value, seen) = seen(measurement, meta.sequence);
        self.course.take_value(t_s, measurement, value);
        let is_measured = measurement.refusal.is_none();
        if let Some(cause) = value.and_then(|value| alarm_of(&measurement.frame, value)) {
            self.raise(&cause);
        }
        let turns = &mut self.course.turns;
        let turn = meta.angle_deg.and_then(|angle| turns.push(angle.value, sweep_deg, is_measured));
        self.print(&meta, latency_ms, saved, turn);
        if let Some(part) = self.course.presence.push(seen) {
            self.part(part);
        }
    }

    /// Measures a frame, or counts why it cannot be; gives it back where its memory is whole.
    fn measure(&mut self, mut frame: Frame, meta: &LiveMeta, remarks: &Remarks) -> Option<Frame> {
        if let (None, Some(host)) = (meta.device_t, meta.host_t) {
            // To seconds, over which a diameter settles, that of arrival is as good.
            frame.meta.t_ns = host.t_ns;
        }
        let conditions = self.take_conditions(meta);
        let number = format!("{:06}", meta.sequence);
        let stem = if remarks.stem.is_empty() { &number } else { &remarks.stem };
        let of = StatedOf { stem, scale: remarks.scale.as_ref(), changed: &remarks.changed };
        if let Err(why) = self.checks.check(of, &frame) {
            self.stream.push_unreadable(stem, why);
            return Some(frame);
        }
        match self.stream.prepared(stem, frame) {
            Ok(frame) => {
                // What a refused frame is refused for stands in its measurement; a field without a
                // part is one under any conditions.
                let measured = self.stream.push_prepared(stem, &frame.meta, &frame.view()).is_ok();
                if let (true, Err(why)) = (measured, conditions) {
                    self.stream.refuse_measured(why);
                }
                Some(frame)
            }
            Err(error) => {
                self.stream.push_unreadable(stem, error.to_string());
                None
            }
        }
    }

    /// Takes temperatures, zero and angle of a frame.
    ///
    /// # Errors
    /// What is lacking.
    fn take_conditions(&mut self, meta: &LiveMeta) -> Result<(), String> {
        self.taken = TakenConditions::default();
        self.taken = self.beside.conditions.take(&mut self.stream, meta)?;
        match (self.settings.turning, meta.angle_deg) {
            (true, None) => {
                Err("--turning needs the spindle angle of every frame (angle_deg in frames.csv, a \
                                 camera's chunk): the source does not state it"
                    .to_owned())
            }
            _ => Ok(()),
        }
    }

    /// Shows the page of `--setup`, where it is time.
    fn set_up(&mut self, t_s: f64, frame: Option<&Frame>, meta: &LiveMeta) {
        let (Some(page), Some(frame)) = (&mut self.beside.setup, frame) else { return };
        if !page.is_due(t_s) {
            return;
        }
        let refusal = self.stream.measurement().refusal.as_ref();
        let of = PageOf { frame, meta, edges: self.stream.edges(), refusal };
        let keys = page.look(t_s, &of, !self.shown.is_json());
        self.shown.set_up(keys);
    }

    /// Keeps the frame for a page, where it is time.
    fn picture(&mut self, t_s: f64, frame: Option<&Frame>, number: u64) {
        let (Some(picture), Some(frame)) = (&mut self.beside.picture, frame) else { return };
        if picture.is_due(t_s) {
            let view = frame.view();
            let view = if self.settings.vertical { view.transposed() } else { view };
            let scale = PictureScale::of(self.stream.measurement(), self.settings.scale);
            picture.show(t_s, Pictured { number, view, edges: self.stream.edges(), scale });
        }
    }

    /// Saves the frame that was measured last where it is invalid or not good; its file.
    fn save(&mut self, number: u64, frame: impl FnOnce() -> Option<Frame>) -> Option<String> {
        let measurement = self.stream.measurement();
        let is_bad = match &measurement.refusal {
            Some(refusal) => !is_empty(refusal.reason),
            // Until a diameter has settled it is not proven, and nothing is wrong with its frames.
            None => measurement.judgement.severity() > 0 && is_settled(measurement),
        };
        if !is_bad {
            return None;
        }
        self.shown.save(number, frame)
    }

    fn print(&mut self, meta: &LiveMeta, latency_ms: Option<f64>, saved: Option<String>, turn: Option<Turn>) {
        let missed = std::mem::take(&mut self.missed);
        let (slope, is_alarmed) = (self.course.trend.slope(), self.alarm.cause().is_some());
        let measurement = self.stream.measurement();
        let (conditions, is_settled) = (self.taken, is_settled(measurement));
        self.shown.frame(&ShownFrame {
            measurement,
            meta,
            missed,
            latency_ms,
            slope,
            is_alarmed,
            conditions,
            is_settled,
            turn,
            saved,
        });
    }

    fn gap(&mut self, gap: &Gap) {
        self.missed.lost += gap.lost;
        self.missed.incomplete += gap.incomplete;
        self.missed.dropped += gap.dropped;
        gap.why.iter().for_each(|why| self.course.note_refusal(why));
        self.shown.gap(gap);
    }

    fn lost(&mut self, why: String) {
        self.raise(&format!("{} is gone: {why}", self.settings.name));
        self.course.validity.lost(why);
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
            self.beside.on_alarm.start(cause);
        }
    }

    /// Shows what is now; a reading that has become invalid once.
    fn look(&mut self, counters: &Counters) {
        let invalid = self.course.validity.invalid(self.course.now_s());
        if let Some(invalid) = self.course.newly_invalid(invalid.as_ref()) {
            // A refused frame has a line of its own, with the reason.
            if !matches!(invalid, Invalid::Refused(_) | Invalid::NoFrame) {
                self.shown.invalid(invalid);
            }
        }
        if self.beside.setup.is_some() {
            return;
        }
        let reading = self.course.reading(invalid.as_ref());
        let edges = self.stream.edges().filter(|_| reading.is_ok() && self.shown.is_live());
        let profile = edges.and_then(|edges| diameters_along(edges, self.settings.scale));
        self.shown.now(&Now {
            reading,
            profile,
            slope: self.course.trend.slope(),
            pace: &self.course.pace,
            counters,
            parts: self.course.presence.parts(),
            alarm: self.alarm.cause(),
        });
    }
}
