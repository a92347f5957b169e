//! A live source with an encoder beside it: angles within 0.2°, or a gap with its reason.

use std::collections::VecDeque;
use std::time::Duration;

use shadowgauge::frame::{Buffer, Frame, FrameMeta, PixelFormat};
use shadowgauge::position::{
    EncoderDirection, EncoderSample, EncoderSettings, LatchedAt, SampledEncoder, TriggerCount,
};
use shadowgauge::source::live::{
    Binding, Bound, Clock, EncoderSamples, Known, LiveMeta, NewFrame, Produced, Producer, Provenance,
    Remarks, SampleClock, Timestamp,
};

use super::conformance::Factory;

/// 600/min, 32 frames a turn, exposures of 2 ms, 4096 counts a turn.
const PERIOD_NS: u64 = 3_125_000;
const COUNTS: f64 = 4096.0;
const TURN_NS: f64 = 1e8;
const EXPOSURE_US: f64 = 2000.0;
const LATCHES: [LatchedAt; 3] = [LatchedAt::ExposureStart, LatchedAt::ExposureEnd, LatchedAt::FrameStart];
const DIRECTIONS: [EncoderDirection; 2] = [EncoderDirection::Rising, EncoderDirection::Falling];

/// Frames taken at these triggers, numbered as they come.
struct Camera {
    triggers: VecDeque<i64>,
    next: u64,
    doubled_ns: u64,
    last: i64,
}

impl Camera {
    fn boxed(triggers: impl IntoIterator<Item = i64>) -> Box<dyn Producer> {
        Box::new(Self { triggers: triggers.into_iter().collect(), next: 0, doubled_ns: 300_000, last: -1 })
    }
}

impl Producer for Camera {
    fn produce(&mut self, _: Option<Frame>, _: Duration) -> Produced {
        let Some(trigger) = self.triggers.pop_front() else { return Produced::End(None) };
        let again_ns = if trigger == self.last { self.doubled_ns } else { 0 };
        let t_ns = TURN_NS as u64 + trigger as u64 * PERIOD_NS + again_ns;
        (self.last, self.next) = (trigger, self.next + 1);
        let sequence = self.next - 1;
        let frame = Frame::new(
            Buffer::U8(vec![sequence as u8; 6]),
            PixelFormat::Mono8,
            2,
            3,
            FrameMeta { t_ns, exposure_us: EXPOSURE_US, ..FrameMeta::default() },
        );
        let meta = LiveMeta {
            sequence,
            device_t: Some(Timestamp { t_ns, clock: Clock::Device }),
            exposure_us: Some(Known::stated(EXPOSURE_US)),
            ..LiveMeta::default()
        };
        Produced::Frame(Box::new(NewFrame { frame: frame.unwrap(), meta, remarks: Remarks::default() }))
    }
}

/// Samples each ms, some at a look, as a file that grows.
struct Growing {
    samples: VecDeque<EncoderSample>,
    a_look: usize,
}

impl Growing {
    fn boxed(settings: &EncoderSettings, a_look: usize, has_index: bool) -> Box<dyn EncoderSamples> {
        let sign = if settings.direction == EncoderDirection::Rising { 1 } else { -1 };
        let sample = |ms: u64| {
            let count = (ms as f64 * 1e6 * COUNTS / TURN_NS).floor() as i64;
            let index = has_index.then_some(sign * (count.div_euclid(4096) * 4096));
            EncoderSample { t_ns: ms * 1_000_000, count: sign * count, index, z_mm: Some(0.001 * ms as f64) }
        };
        Box::new(Self { samples: (0..700).map(sample).collect(), a_look })
    }
}

impl EncoderSamples for Growing {
    fn look(&mut self) -> Result<Vec<EncoderSample>, String> {
        let count = self.a_look.min(self.samples.len());
        Ok(self.samples.drain(..count).collect())
    }

    fn clock(&self) -> Option<SampleClock> {
        Some(SampleClock::Frames)
    }
}

fn settings(latched_at: LatchedAt, direction: EncoderDirection) -> EncoderSettings {
    let frame_start_delay_us = if latched_at == LatchedAt::FrameStart { 150.0 } else { 0.0 };
    EncoderSettings {
        latched_at,
        direction,
        frame_start_delay_us,
        frames_per_turn: Some(32),
        ..EncoderSettings::new(4096)
    }
}

/// From the instant of the latch to mid-exposure, ns.
fn to_middle_ns(settings: &EncoderSettings) -> f64 {
    match settings.latched_at {
        LatchedAt::ExposureStart => 1e6,
        LatchedAt::ExposureEnd => -1e6,
        LatchedAt::FrameStart => 1.15e6,
    }
}

/// Frames by number, and gaps with their reason.
fn all(mut source: Box<dyn Producer>) -> (Vec<NewFrame>, Vec<(u64, String)>) {
    let (mut frames, mut gaps) = (Vec::new(), Vec::new());
    loop {
        match source.produce(None, Duration::ZERO) {
            Produced::Frame(frame) => frames.push(*frame),
            Produced::Incomplete(number, why) => gaps.push((number, why)),
            Produced::Nothing => {}
            Produced::End(failure) => {
                assert_eq!(failure, None);
                return (frames, gaps);
            }
            other => panic!("{other:?}"),
        }
    }
}

fn off_deg(found: f64, due: f64) -> f64 {
    ((found - due + 180.0).rem_euclid(360.0) - 180.0).abs()
}

#[test]
fn samples_give_angle_and_carriage_within_a_fifth_of_a_degree_whatever_the_latch() {
    for latched_at in LATCHES {
        for direction in DIRECTIONS {
            let settings = settings(latched_at, direction);
            // a trigger ignored and one doubled: every frame has a time of its own, nothing shifts
            let triggers =
                (0..128).filter(|k| *k != 40).flat_map(|k| if k == 70 { vec![k, k] } else { vec![k] });
            let samples = Growing::boxed(&settings, 7, true);
            let binding = Binding::Samples(SampledEncoder::new(settings), samples);
            let (frames, gaps) = all(Box::new(Bound::new(Camera::boxed(triggers), binding, false)));
            assert!(gaps.is_empty() && frames.len() == 128, "{gaps:?}");
            for (frame, number) in frames.iter().zip(0..) {
                assert_eq!(frame.meta.sequence, number);
                let middle_ns = frame.meta.device_t.unwrap().t_ns as f64 + to_middle_ns(&settings);
                let angle = frame.meta.angle_deg.unwrap();
                assert_eq!(
                    (angle.provenance, angle.value),
                    (Provenance::Interpolated, frame.frame.meta.angle_deg)
                );
                assert!(off_deg(angle.value, 360.0 * middle_ns / TURN_NS) < 0.2, "{latched_at:?} {number}");
                // a count of 4096 is 0.088°: u of the sample and the index together 0.036° or more
                let u_deg = frame.meta.u_angle_deg.unwrap();
                assert!((0.035..0.06).contains(&u_deg), "{u_deg}");
                assert!((frame.frame.meta.sweep_deg - 7.2).abs() < 0.2);
                assert!((frame.frame.meta.z_mm - 1e-9 * middle_ns).abs() < 1e-6, "{number}");
            }
        }
    }
}

#[test]
fn triggers_give_angles_and_an_ignored_or_doubled_one_voids_its_turn() {
    for latched_at in LATCHES {
        for direction in DIRECTIONS {
            let settings = settings(latched_at, direction);
            for (bad, word) in [(vec![], "ignored"), (vec![40, 40], "doubled")] {
                let triggers = (0..128).flat_map(|k| if k == 40 { bad.clone() } else { vec![k] });
                let binding = Binding::Triggers(TriggerCount::new(settings, 0).unwrap(), None);
                let (frames, gaps) = all(Box::new(Bound::new(Camera::boxed(triggers), binding, false)));
                assert!(
                    gaps.iter().all(|(_, why)| why.contains("turn 2 is void") && why.contains(word)),
                    "{gaps:?}"
                );
                assert_eq!((frames.len(), gaps.len()), (96, if word == "ignored" { 31 } else { 33 }));
                for frame in &frames {
                    let since_ns =
                        frame.meta.device_t.unwrap().t_ns as f64 - TURN_NS + to_middle_ns(&settings);
                    let sign = if direction == EncoderDirection::Rising { 1.0 } else { -1.0 };
                    let angle = frame.meta.angle_deg.unwrap();
                    assert_eq!(angle.provenance, Provenance::TriggerCount);
                    // no index pulse: a quarter of the step of 11.25°, by √3
                    let u_deg = frame.meta.u_angle_deg.unwrap();
                    assert!((u_deg - 1.624).abs() < 0.01, "{u_deg}");
                    assert!(off_deg(angle.value, sign * 360.0 * since_ns / TURN_NS) < 0.2, "{latched_at:?}");
                }
            }
        }
    }
}

#[test]
fn frames_without_samples_about_them_are_gaps_that_say_so() {
    let settings = settings(LatchedAt::ExposureStart, DIRECTIONS[0]);
    let binding = Binding::Samples(SampledEncoder::new(settings), Growing::boxed(&settings, 1000, false));
    // the samples end at 699 ms, trigger 192 is at 700
    let (frames, gaps) = all(Box::new(Bound::new(Camera::boxed(0..200), binding, false)));
    assert!(frames.len() == 192 && gaps.len() == 8, "{}", frames.len());
    assert!(gaps.iter().all(|(number, why)| *number >= 192 && why.contains("after the last")), "{gaps:?}");
}

#[test]
fn a_bound_source_conforms() {
    let open = |frames: u64| -> Box<dyn Producer> {
        let settings = settings(LatchedAt::ExposureStart, DIRECTIONS[0]);
        let binding = Binding::Samples(SampledEncoder::new(settings), Growing::boxed(&settings, 1000, false));
        Box::new(Bound::new(Camera::boxed(0..frames as i64), binding, false))
    };
    let is_frame = |frame: &Frame, number: u64| frame.view().get(1, 2) == Some(number as f32);
    Factory { open: &open, is_frame: &is_frame }.conforms();
}
