//! The events of a source, measured one after another.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::live_conditions::{LiveConditions, TakenConditions};
use super::on_alarm::OnAlarm;
use super::picture::{Picture, Pictured};
use super::setup_page::{PageOf, SetupPage};
use super::shown::{Missed, Now, Shown, ShownFrame};
use crate::cli::failure::Failure;
use crate::cli::measure::frames::{FrameChecks, StatedOf};
use crate::cli::terminal::output;
use crate::frame::Frame;
use crate::gauge::stated::stated;
use crate::measurement::watch::{
    Alarm, FrameValue, Invalid, Pace, PartValue, Presence, Profile, Seen, Trend, Turn, TurnCover, Validity,
    profile,
};
use crate::measurement::{Measurement, Settled, Stream};
use crate::profile::Reason;
use crate::source::host_t_ns;
use crate::source::live::{Counters, Event, Gap, Lease, LiveFrame, LiveMeta, LiveSource, Remarks};

/// Longest wait for a frame before age and Ctrl-C are looked at: ten looks a second are what a
/// person takes for at once.
const LOOK: Duration = Duration::from_millis(100);
/// Coverage factor of values in pixels, whose freedom is not stated.
const K: f64 = 2.0;
/// Cells of the profile: as many as are read at a glance beside the other figures.
const CELLS: usize = 32;
/// Standard uncertainties of a cell's mean that a profile must differ by to fill its height: of 32
/// cells the range by noise is four of them in the mean.
const NOISE: f64 = 4.0;

/// What a session is given.
#[derive(Debug)]
pub(super) struct SessionSettings {
    /// Time without a frame that ends it.
    pub(super) idle: Option<Duration>,
    /// Age from which a reading is none of now.
    pub(super) stale: Duration,
    /// Name of the source in messages.
    pub(super) name: String,
    /// Whether what must agree are means of whole turns, by the frames' angles.
    pub(super) turning: bool,
    /// Whether the shaft stands upright in the images.
    pub(super) vertical: bool,
    /// Scale of the profile: mm per pixel, or 1 in pixels.
    pub(super) scale: f64,
    /// Whether frames are corrected by a flat field: what is saved is the frame before.
    pub(super) corrects: bool,
}

/// What stands beside the measurement.
pub(super) struct Beside {
    /// The command of the alarm.
    pub(super) on_alarm: OnAlarm,
    /// Temperatures and zeros.
    pub(super) conditions: LiveConditions,
    /// The page of `--setup`.
    pub(super) setup: Option<SetupPage>,
    /// The picture of `--picture`.
    pub(super) picture: Option<Picture>,
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
    beside: Beside,
    /// Conditions of the last frame.
    taken: TakenConditions,
    begun: Instant,
    pace: Pace,
    trend: Trend,
    turns: TurnCover,
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
        settings: SessionSettings,
        beside: Beside,
    ) -> Self {
        let validity = Validity::new(settings.stale.as_secs_f64());
        Self {
            stream,
            checks,
            shown,
            settings,
            beside,
            taken: TakenConditions::default(),
            begun: Instant::now(),
            pace: Pace::default(),
            trend: Trend::default(),
            turns: TurnCover::default(),
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
        // Who sets a gauge up may have no frame that can be measured yet.
        match (failure, is_wanted() && self.measured == 0 && self.beside.setup.is_none()) {
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
        self.beside.on_alarm.finish();
        if let Some(page) = &self.beside.setup {
            page.finish();
        }
        self.shown.end(counters, [self.measured, self.presence.parts()], &self.pace);
        self.alarm.cause().is_some()
    }

    /// Waits until everything that is saved is written.
    ///
    /// # Errors
    /// Where the disk refused.
    pub(super) fn end_saving(self) -> Result<(), Failure> {
        self.shown.end_saving()
    }

    fn is_idle(&self) -> bool {
        let age_s = self.validity.age_s(self.now_s()).unwrap_or_else(|| self.now_s());
        self.settings.idle.is_some_and(|idle| age_s > idle.as_secs_f64())
    }

    // ---- events

    fn frame(&mut self, frame: LiveFrame) {
        let LiveFrame { lease: Lease { frame, slot }, meta, remarks } = frame;
        let sweep_deg = frame.meta.sweep_deg;
        remarks.notices.iter().for_each(|notice| tracing::warn!("{notice}"));
        if !self.presence.is_there() {
            // Until a part is there it may be another one.
            self.stream.restart_settling();
        }
        let raw = (self.settings.corrects && self.shown.saves_frames()).then(|| frame.clone());
        let measured = self.measure(frame, &meta, &remarks);
        let t_s = self.now_s();
        self.set_up(t_s, measured.as_ref(), &meta);
        self.picture(t_s, measured.as_ref(), meta.sequence);
        let saved = self.save(meta.sequence, || raw.or_else(|| measured.clone()));
        if let Some(frame) = measured {
            slot.give_back(frame);
        }
        let latency_ms = meta.host_t.map(|t| host_t_ns().saturating_sub(t.t_ns) as f64 * 1e-6);
        self.pace.push(t_s, latency_ms);
        let (value, seen) = seen(self.stream.measurement(), meta.sequence);
        self.take_value(t_s, value);
        let is_measured = self.stream.measurement().refusal.is_none();
        let turn = meta.angle_deg.and_then(|angle| self.turns.push(angle.value, sweep_deg, is_measured));
        self.print(&meta, latency_ms, saved, turn);
        if let Some(part) = self.presence.push(seen) {
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
            picture.show(t_s, Pictured { number, view, edges: self.stream.edges() });
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

    /// The value of the frame that was measured last, or that it has none.
    fn take_value(&mut self, t_s: f64, value: Option<FrameValue>) {
        let measurement = self.stream.measurement();
        let refusal = measurement.refusal.as_ref().map(|refusal| refusal.why.clone());
        let unsettled = measurement.settled.as_ref().and_then(Settled::why);
        let cause = value.filter(|v| v.severity > 1).map(|v| {
            let [d, u] = stated(v.value, v.expanded_u);
            format!("frame {}: {} at {d} mm, U {u} mm", measurement.frame, v.word)
        });
        if let (Some(why), None) = (&refusal, &self.first_refusal) {
            self.first_refusal = Some(why.clone());
        }
        self.validity.frame(t_s, refusal.map(Invalid::Refused).or(unsettled.map(Invalid::NotSettled)));
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

    fn print(&mut self, meta: &LiveMeta, latency_ms: Option<f64>, saved: Option<String>, turn: Option<Turn>) {
        let missed = std::mem::take(&mut self.missed);
        let (slope, is_alarmed) = (self.trend.slope(), self.alarm.cause().is_some());
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
            self.beside.on_alarm.start(cause);
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
        if self.beside.setup.is_some() {
            return;
        }
        let profile = reading.is_ok().then(|| self.profile()).flatten();
        self.shown.now(&Now {
            reading,
            profile,
            slope: self.trend.slope(),
            pace: &self.pace,
            counters,
            parts: self.presence.parts(),
            alarm: self.alarm.cause(),
        });
    }

    /// Diameters along the last frame, as far as a terminal shows them.
    fn profile(&self) -> Option<Profile> {
        let edges = self.stream.edges().filter(|_| self.shown.is_live())?;
        let scale = self.settings.scale;
        let in_cell = (edges.columns() / CELLS).max(1) as f64;
        let (top, bottom) =
            edges.top.iter().zip(&edges.bottom).find(|(t, b)| t.is_usable() && b.is_usable())?;
        let u_px =
            |own: f32, shared: f32| (f64::from(own).powi(2) / in_cell + f64::from(shared).powi(2)).sqrt();
        let u = u_px(top.u_own_px, top.u_shared_px).hypot(u_px(bottom.u_own_px, bottom.u_shared_px));
        let widths = (0..edges.columns()).map(|column| edges.width_px(column).map(|width| scale * width));
        profile(widths, CELLS, NOISE * scale * u)
    }
}

fn is_empty(reason: Reason) -> bool {
    matches!(reason, Reason::NoEdge | Reason::LowContrast)
}

/// Whether the diameter is good by its course in time; true where that is not asked for.
fn is_settled(measurement: &Measurement) -> bool {
    measurement.settled.is_none_or(|settled| settled.u_trend_mm().is_some())
}

/// The value of a measured frame, and whether a part is in it.
fn seen(measurement: &Measurement, sequence: u64) -> (Option<FrameValue>, Seen) {
    let millimetres = measurement.diameter.as_ref().map(|d| (d.diameter.d_mm, d.expanded_u_mm));
    let pixels = measurement.largest.as_ref().map(|l| (l.diameter_px, K * l.u_px));
    if let Some(refusal) = &measurement.refusal {
        return (None, if is_empty(refusal.reason) { Seen::Empty } else { Seen::Unclear });
    }
    let value = millimetres.or(pixels).filter(|(value, _)| value.is_finite());
    let Some((value, expanded_u)) = value else { return (None, Seen::Unclear) };
    let (severity, word) = (measurement.judgement.severity(), measurement.judgement.word());
    let is_settled = is_settled(measurement);
    let value = FrameValue { sequence, value, expanded_u, severity, word, is_settled };
    (Some(value), Seen::Part(value))
}
