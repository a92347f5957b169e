//! Frames of a head on the wire, place by place, each by a trigger of its own.
//!
//! A frame belongs to a trigger where it was exposed after it: the head's clock is latched before
//! every trigger, and a frame that is older was made by an earlier one (a trigger that counted
//! twice, a frame that was late). The head draws the noise of a frame by its number, which is set
//! before the trigger: a frame that is lost is taken again, and is the same.

use std::time::{Duration, Instant};

use crate::frame::{Frame, FrameSource, SourceError};
use crate::source::commanded::{Arrived, CommandedHead, HeadError, HeadFrame, Place};

/// Wait for a frame before the head is asked what became of it: with two answers that are awaited
/// as long, a head that is gone is reported within a second.
const LOOK: Duration = Duration::from_millis(250);
/// Longest wait for a frame of a head that answers: two minutes are no exposure, and no drawing of
/// a frame that a loop could wait for in every pass.
const LONGEST: Duration = Duration::from_secs(120);
/// Triggers for one frame: with one frame of a hundred lost, one of 10⁶ fails.
const TRIGGERS: usize = 3;
/// Largest distance of a frame from its place, mm and degrees: both are doubles that travel
/// unchanged, and rounding where a head computes with them is below 1e-9.
const AT_PLACE: f64 = 1e-6;

/// A place to take a frame at.
pub(super) type Stop = Place;

/// Numbers of the frames of an object.
#[derive(Debug)]
pub(super) struct Numbers<'a> {
    /// Id of the object's first frame.
    pub first_id: u64,
    /// Number of the next one, from 0.
    pub next: &'a mut u64,
}

/// What became of a trigger.
enum Taken {
    Frame(Frame),
    /// No frame that can be measured, and why; another trigger may give it.
    Lost(String),
}

/// Counters of the head before a trigger.
struct Before {
    clock_ns: u64,
    sent: Option<f64>,
    missed: Option<f64>,
}

/// Frames on their way from a head.
pub(super) struct WireFrames<'a> {
    head: &'a mut dyn CommandedHead,
    name: &'a str,
    stops: Vec<Stop>,
    next: usize,
    numbers: Numbers<'a>,
}

impl<'a> WireFrames<'a> {
    pub(super) fn new(
        head: &'a mut dyn CommandedHead,
        name: &'a str,
        stops: Vec<Stop>,
        numbers: Numbers<'a>,
    ) -> Self {
        Self { head, name, stops, next: 0, numbers }
    }

    fn trigger(&mut self, stop: &Stop) -> Result<Taken, HeadError> {
        let number = *self.numbers.next + 1;
        self.head.set("CarriageZ", &stop.z_mm.to_string())?;
        self.head.set("SpindleAngle", &stop.angle_deg.to_string())?;
        self.head.set("HeadFrame", &number.to_string())?;
        let before = Before {
            sent: self.head.number("FramesSent"),
            missed: self.head.number("TriggersMissed"),
            clock_ns: self.clock_ns()?,
        };
        self.head.execute("TriggerSoftware")?;
        self.wait(stop, &before)
    }

    fn clock_ns(&self) -> Result<u64, HeadError> {
        match self.head.now_ns() {
            Some(now_ns) => Ok(now_ns),
            None => Err(self.head.check().err().unwrap_or(HeadError::NoClock)),
        }
    }

    fn wait(&mut self, stop: &Stop, before: &Before) -> Result<Taken, HeadError> {
        let (began, mut was_sent) = (Instant::now(), false);
        while began.elapsed() < LONGEST {
            match self.head.receive(LOOK)? {
                Arrived::Frame(arrived) if arrived.exposed_ns.is_some_and(|t_ns| t_ns < before.clock_ns) => {
                    tracing::debug!("a frame of an earlier trigger is left out");
                    self.head.recycle(arrived.frame);
                }
                Arrived::Frame(arrived) => return Ok(at_place(*arrived, stop)),
                Arrived::Incomplete(why) => return Ok(Taken::Lost(why)),
                Arrived::Nothing => {
                    if let Some(why) = self.silent(before, &mut was_sent)? {
                        return Ok(Taken::Lost(why));
                    }
                }
            }
        }
        Ok(Taken::Lost(format!("no frame came for {} s, although the head answers", LONGEST.as_secs())))
    }

    /// Why no frame comes any more; `None` while the head still draws it, or its packets are on
    /// their way.
    fn silent(&self, before: &Before, was_sent: &mut bool) -> Result<Option<String>, HeadError> {
        self.head.check()?;
        if let Some(words) = self.head.value("HeadMessage").filter(|words| !words.is_empty()) {
            return Err(HeadError::Refused(words));
        }
        if self.head.number("TriggersMissed") != before.missed {
            return Ok(Some("the trigger made no frame".to_owned()));
        }
        let is_sent = self.head.number("FramesSent") != before.sent;
        let is_lost = is_sent && *was_sent;
        *was_sent = is_sent;
        let why =
            "it was sent, but its packets did not arrive (a firewall, or larger than the network carries)";
        Ok(is_lost.then(|| why.to_owned()))
    }

    fn failed(&self, stop: &Stop, why: &str) -> SourceError {
        let Self { name, next, stops, .. } = self;
        let (z_mm, angle_deg) = (stop.z_mm, stop.angle_deg);
        let frame = format!("frame {} of {} (z = {z_mm:.3} mm, {angle_deg:.1}°)", next + 1, stops.len());
        SourceError { what: format!("{name}: {frame}: {why}"), cause: None }
    }
}

/// The frame, unless it states another place.
fn at_place(arrived: HeadFrame, stop: &Stop) -> Taken {
    let Some(place) = arrived.place else {
        return Taken::Lost("it states no place (ChunkSpindleAngle, ChunkCarriageZ)".to_owned());
    };
    let is_there = |found: f64, wanted: f64| (found - wanted).abs() <= AT_PLACE;
    if is_there(place.z_mm, stop.z_mm) && is_there(place.angle_deg, stop.angle_deg) {
        return Taken::Frame(arrived.frame);
    }
    Taken::Lost(format!("it was taken at z = {:.3} mm, {:.1}°", place.z_mm, place.angle_deg))
}

impl FrameSource for WireFrames<'_> {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        let Some(stop) = self.stops.get(self.next).copied() else { return Ok(None) };
        let mut lost = String::new();
        for _ in 0..TRIGGERS {
            match self.trigger(&stop) {
                Ok(Taken::Frame(mut frame)) => {
                    frame.meta.frame_id = self.numbers.first_id + *self.numbers.next;
                    *self.numbers.next += 1;
                    self.next += 1;
                    return Ok(Some(frame));
                }
                Ok(Taken::Lost(why)) => {
                    tracing::debug!("{}: {why}; it is taken again", self.failed(&stop, "no frame"));
                    lost = why;
                }
                Err(why) => return Err(self.failed(&stop, &why.to_string())),
            }
        }
        Err(self.failed(&stop, &format!("it did not come by {TRIGGERS} triggers: {lost}")))
    }

    fn remaining(&self) -> Option<usize> {
        Some(self.stops.len() - self.next)
    }

    fn recycle(&mut self, frame: Frame) {
        self.head.recycle(frame);
    }
}
