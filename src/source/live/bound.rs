//! A source whose frames are bound to spindle angle and carriage position by an encoder beside it:
//! by timed samples, or by the numbers of the encoder's triggers.
//!
//! A frame is held until its place is known: until samples reach beyond its exposure and an index
//! pulse after it has checked the count, or until the turn of its trigger is over (and, where index
//! pulses are known, checked). What stands in a
//! void turn is a gap with the reason. Frames are not held without bound: beyond a number of bytes,
//! and of a turn that takes longer than is waited for, they are given with the checks there were.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use super::metadata::{Known, LiveMeta, Provenance};
use super::producer::{NewFrame, Produced, Producer};
use crate::frame::{CameraBinding, Frame};
use crate::position::{
    EncoderSample, Exposure, Place, SampledEncoder, SampledPlace, TriggerCount, Triggered,
};

/// Most bytes of frames that are held: 64 frames of 2048 × 2048 in 8 bits, two turns of 32.
const MOST_BYTES: usize = 1 << 28;
/// Longest wait for samples, or for the pulse that ends a turn: a turn at 30/min.
const LONGEST: Duration = Duration::from_secs(2);

/// Samples of an encoder that come from elsewhere.
pub(crate) trait EncoderSamples: Send {
    /// The samples since the last look, in the order of their times.
    ///
    /// # Errors
    /// What cannot be read: it names the place.
    fn look(&mut self) -> Result<Vec<EncoderSample>, String>;

    /// The clock that their times are of; `None` before it is known.
    fn clock(&self) -> Option<SampleClock>;
}

/// Index pulses of an encoder, by their times, that come from elsewhere.
pub(crate) trait IndexTimes: Send {
    /// The pulses since the last look, ns, in their order.
    ///
    /// # Errors
    /// What cannot be read: it names the place.
    fn look(&mut self) -> Result<Vec<u64>, String>;

    /// The clock that they are of; `None` before it is known.
    fn clock(&self) -> Option<SampleClock>;
}

/// Clocks that samples may be of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SampleClock {
    /// That of the frames' own times: the device's, a table's, a recording's.
    Frames,
    /// This machine's.
    Host,
}

/// How frames are bound.
pub(crate) enum Binding {
    /// By samples of the encoder.
    Samples(SampledEncoder, Box<dyn EncoderSamples>),
    /// By the numbers of its triggers, checked by its index pulses where they are known.
    Triggers(TriggerCount, Option<Box<dyn IndexTimes>>),
}

/// What waits, in the order of the source.
enum Held {
    Frame(Box<NewFrame>, Instant),
    Other(Produced),
}

/// A source with an encoder beside it.
pub(crate) struct Bound {
    source: Box<dyn Producer>,
    binding: Binding,
    held: VecDeque<Held>,
    bytes: usize,
    /// Places of the first held frames.
    places: VecDeque<SampledPlace>,
    ready: VecDeque<Produced>,
    spare: Option<Frame>,
    /// Whether frames wait on a clock of their own: a live source, not a file.
    is_live: bool,
}

impl Bound {
    /// Binds the frames of a source; a live one is not waited for longer than two seconds.
    pub(crate) fn new(source: Box<dyn Producer>, binding: Binding, is_live: bool) -> Self {
        let (held, places, ready) = (VecDeque::new(), VecDeque::new(), VecDeque::new());
        Self { source, binding, held, bytes: 0, places, ready, spare: None, is_live }
    }

    fn hold(&mut self, new: Box<NewFrame>) {
        if let Binding::Triggers(count, index) = &mut self.binding {
            let own_ns = new.meta.device_t.or(new.meta.exposed_t).map(|t| t.t_ns);
            let clock = index.as_ref().and_then(|index| index.clock());
            let t_ns = clock.map_or(own_ns, |clock| time_ns(&new.meta, clock)).unwrap_or(0);
            let exposure_us = exposure_us(&new).unwrap_or(0.0);
            count.push(Triggered { number: new.meta.sequence, t_ns, exposure_us });
        }
        self.bytes += bytes(&new.frame);
        self.held.push_back(Held::Frame(new, Instant::now()));
    }

    /// Takes samples that came, and moves what is decided to `ready`.
    ///
    /// # Errors
    /// Samples that cannot be read or contradict the stated encoder.
    fn decide(&mut self, is_end: bool) -> Result<(), String> {
        if let Binding::Samples(encoder, samples) = &mut self.binding {
            for sample in samples.look()? {
                encoder.push(sample)?;
            }
        }
        if let Binding::Triggers(count, Some(index)) = &mut self.binding {
            index.look()?.into_iter().for_each(|pulse_ns| count.index(pulse_ns));
        }
        loop {
            match self.held.pop_front() {
                None => return Ok(()),
                Some(Held::Other(other)) => self.ready.push_back(other),
                Some(Held::Frame(new, since)) => {
                    let Some(place) = self.place(&new, since, is_end) else {
                        self.held.push_front(Held::Frame(new, since));
                        return Ok(());
                    };
                    self.bytes -= bytes(&new.frame);
                    let provenance = match self.binding {
                        Binding::Samples(..) => Provenance::Interpolated,
                        Binding::Triggers(..) => Provenance::TriggerCount,
                    };
                    self.ready.push_back(placed(new, place, provenance));
                }
            }
        }
    }

    /// Place of the first held frame, where it is decided.
    fn place(&mut self, new: &NewFrame, since: Instant, is_end: bool) -> Option<SampledPlace> {
        let is_full = self.bytes > MOST_BYTES || self.is_live && since.elapsed() > LONGEST;
        match &mut self.binding {
            Binding::Samples(encoder, samples) => {
                let void =
                    |why: &str| SampledPlace { place: Place::Void(why.to_owned()), u_deg: None, z_mm: None };
                let Some(clock) = samples.clock() else {
                    return (is_end || is_full).then(|| void("no sample of the encoder came"));
                };
                let Some(t_ns) = time_ns(&new.meta, clock) else { return Some(void(untimed(clock))) };
                let exposure = Exposure { t_ns, exposure_us: exposure_us(new) };
                let is_decided = encoder.covers(&exposure) && encoder.is_checked(&exposure);
                (is_decided || is_end || is_full).then(|| encoder.place(&exposure))
            }
            Binding::Triggers(count, _) => {
                if self.places.is_empty() {
                    self.places.extend(count.decided(is_end || is_full));
                }
                self.places.pop_front()
            }
        }
    }
}

/// A frame with its place, or a gap.
fn placed(mut new: Box<NewFrame>, at: SampledPlace, provenance: Provenance) -> Produced {
    match at.place {
        Place::Void(why) => Produced::Incomplete(new.meta.sequence, why),
        Place::At { angle_deg, sweep_deg } => {
            (new.frame.meta.angle_deg, new.frame.meta.sweep_deg) = (angle_deg, sweep_deg);
            new.meta.angle_deg = Some(Known { value: angle_deg, provenance });
            new.meta.u_angle_deg = at.u_deg;
            if let Some(z_mm) = at.z_mm {
                new.frame.meta.z_mm = z_mm;
                new.meta.z_mm = Some(Known { value: z_mm, provenance });
            }
            Produced::Frame(new)
        }
    }
}

fn bytes(frame: &Frame) -> usize {
    let view = frame.view();
    view.rows() * view.columns() * usize::from(view.format().bit_depth()).div_ceil(8)
}

fn exposure_us(new: &NewFrame) -> Option<f64> {
    let own = Some(new.frame.meta.exposure_us).filter(|us| *us > 0.0);
    new.meta.exposure_us.map(|known| known.value).or(own)
}

/// Time of a frame on the clock of the samples, ns. When a frame arrived is no time of its
/// exposure.
fn time_ns(meta: &LiveMeta, clock: SampleClock) -> Option<u64> {
    let time = match clock {
        SampleClock::Frames => meta.device_t,
        SampleClock::Host => meta.exposed_t,
    };
    time.map(|t| t.t_ns)
}

fn untimed(clock: SampleClock) -> &'static str {
    match clock {
        SampleClock::Frames => "it has no time of its exposure (t_ns), by which samples are bound to it",
        SampleClock::Host => {
            "its exposure has no time on this machine's clock: the camera's cannot be latched; sample by the camera's clock (t_ns)"
        }
    }
}

impl Producer for Bound {
    fn camera(&self) -> Option<&CameraBinding> {
        self.source.camera()
    }

    fn produce(&mut self, spare: Option<Frame>, wait: Duration) -> Produced {
        self.spare = spare.or(self.spare.take());
        if let Some(ready) = self.ready.pop_front() {
            return ready;
        }
        let is_over = match self.source.produce(self.spare.take(), wait) {
            Produced::Nothing => false,
            Produced::Frame(new) => {
                self.hold(new);
                false
            }
            other => {
                let is_over = matches!(other, Produced::Lost(_) | Produced::End(_));
                self.held.push_back(Held::Other(other));
                is_over
            }
        };
        if let Err(why) = self.decide(is_over) {
            return Produced::End(Some(format!("the encoder: {why}")));
        }
        self.ready.pop_front().unwrap_or(Produced::Nothing)
    }

    fn start(&mut self) {
        self.source.start();
    }

    fn stop(&mut self) {
        self.source.stop();
    }
}
