//! Frames that the encoder triggers, by the numbers of their triggers alone.
//!
//! ```text
//! φ = φ_index ± 360°·k/n + ω·τ
//! ```
//!
//! k triggers after an index pulse, n a turn; ω by the times of the frames, τ from the trigger to
//! the middle of the exposure (`latched_at`). Numbers that the source shows as lost are triggers.
//! A trigger that was ignored leaves no number: it shows as a time between two frames that is twice
//! the usual one, a doubled one as a time of next to nothing. Its turn is void. The triggers after
//! it keep their angles, because the time states how many came; where it does not state it within a
//! quarter of a step, all that follows is void.
//!
//! Where index pulses are known by their times, each checks the count of the turn before it, and a
//! turn waits for its pulse: one that comes half a trigger or more off makes what lies before it
//! void, and triggers are counted from it anew. A turn that no pulse has checked rests on the times
//! alone: a quarter of a step to either side is in the uncertainty of its angles.

use std::collections::VecDeque;

use super::binding::Place;
use super::encoder::EncoderSettings;
use super::sampled::SampledPlace;

/// Times on either side of one that make the usual one, a median: one that is off does not move it.
const EITHER_SIDE: usize = 2;
/// Share of a step by which a time between two frames may lie off whole steps: half of what
/// separates one step from none or two.
const OFF_STEPS: f64 = 0.25;
/// Most steps that the time between two frames states: speed known to 5 % gives five steps to a
/// quarter of one.
const MOST_STEPS: f64 = 5.0;
/// Most turns whose void is remembered: frames that still wait are of a few.
const MOST_VOID: usize = 64;
/// Triggers by which an index pulse may come off the place of the first one: half of what separates
/// a count that is right from one that is wrong by one.
const OFF_INDEX: f64 = 0.5;
/// Triggers before the first frame that is there, within which a pulse checks anything.
const MOST_BEFORE: f64 = 2.0;

/// A triggered frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triggered {
    /// Its number, as the source counts.
    pub number: u64,
    /// Its time, ns.
    pub t_ns: u64,
    /// Exposure time, µs.
    pub exposure_us: f64,
}

/// A frame whose trigger is counted.
#[derive(Clone, Debug)]
struct Counted {
    frame: Triggered,
    /// Triggers since the index pulse; `None` where it is not known any more.
    trigger: Option<i64>,
    /// Usual time from trigger to trigger about it, ns.
    step_ns: f64,
    /// What the time since the frame before lies off whole steps, steps.
    off_steps: f64,
    /// Whether an index pulse after it has checked the count.
    is_checked: bool,
    /// Why that pulse made it void.
    void: Option<String>,
}

/// Index pulses by their times.
#[derive(Clone, Debug, Default)]
struct IndexPulses {
    /// Whether turns wait for them.
    is_awaited: bool,
    /// Those that no frame has come after yet, ns.
    waiting: VecDeque<u64>,
    /// Triggers of the first one before the first frame of its turn, -1 to 0.
    phase: Option<f64>,
}

/// Frames counted from an index pulse on, in the order in which they were taken.
#[derive(Clone, Debug)]
pub struct TriggerCount {
    settings: EncoderSettings,
    per_turn: i64,
    /// Number of the first frame after an index pulse.
    first: u64,
    newest: Option<Triggered>,
    /// Frames that are not counted yet, with the time a trigger from the one before, ns.
    waiting: VecDeque<(Triggered, Option<f64>)>,
    /// The times of the last frames that were counted, ns.
    past_ns: VecDeque<f64>,
    /// The last frame that was counted, with its trigger.
    last: Option<(Triggered, Option<i64>)>,
    /// Frames whose turn has not ended.
    counted: VecDeque<Counted>,
    void: VecDeque<(i64, String)>,
    index: IndexPulses,
}

impl TriggerCount {
    /// Frames of which `first` is the number of the first after an index pulse; `frames_per_turn`
    /// frames are triggered a turn.
    ///
    /// # Errors
    /// An encoder without `frames_per_turn`.
    pub fn new(settings: EncoderSettings, first: u64) -> Result<Self, String> {
        let Some(per_turn) = settings.frames_per_turn else {
            return Err("frames_per_turn is needed: how many frames the encoder triggers a turn".to_owned());
        };
        Ok(Self {
            settings,
            per_turn: i64::from(per_turn),
            first,
            newest: None,
            waiting: VecDeque::new(),
            past_ns: VecDeque::new(),
            last: None,
            counted: VecDeque::new(),
            void: VecDeque::new(),
            index: IndexPulses::default(),
        })
    }

    /// With index pulses, which come by [`Self::index`]: a turn waits for the one that ends it.
    #[must_use]
    pub fn with_index(mut self) -> Self {
        self.index.is_awaited = true;
        self
    }

    /// An index pulse at a time, ns, on the clock of the frames; pulses come in order.
    pub fn index(&mut self, t_ns: u64) {
        self.index.waiting.push_back(t_ns);
    }

    /// The next frame.
    pub fn push(&mut self, frame: Triggered) {
        let time_ns = self.newest.map(|before| time_a_trigger(&before, &frame));
        self.newest = Some(frame);
        self.waiting.push_back((frame, time_ns));
        while self.waiting.len() > EITHER_SIDE {
            self.count_next();
        }
    }

    /// Frames whose place was not given yet.
    pub fn undecided(&self) -> usize {
        self.counted.len() + self.waiting.len()
    }

    fn count_next(&mut self) {
        let Some((frame, time_ns)) = self.waiting.pop_front() else { return };
        let after = self.waiting.iter().filter_map(|(_, time_ns)| *time_ns);
        let mut times: Vec<f64> = self.past_ns.iter().copied().chain(time_ns).chain(after).collect();
        times.sort_by(f64::total_cmp);
        let step_ns = times.get(times.len() / 2).copied().unwrap_or(0.0);
        let mut off_steps = 0.0;
        let trigger = match self.last {
            None => i64::try_from(i128::from(frame.number) - i128::from(self.first)).ok(),
            Some((before, last)) => {
                let numbers = frame.number.saturating_sub(before.number) as f64;
                let steps = frame.t_ns.saturating_sub(before.t_ns) as f64 / step_ns;
                off_steps = steps - steps.round();
                last.and_then(|last| self.after(last, numbers, steps))
            }
        };
        self.past_ns.extend(time_ns);
        if self.past_ns.len() > EITHER_SIDE {
            self.past_ns.pop_front();
        }
        self.last = Some((frame, trigger));
        let (is_checked, void) = (false, None);
        self.counted.push_back(Counted { frame, trigger, step_ns, off_steps, is_checked, void });
    }

    /// Holds the pulses against the frames that have come after them.
    fn check_index(&mut self) {
        while let Some(pulse_ns) = self.index.waiting.front().copied() {
            let Some(after) = self.counted.iter().position(|c| c.frame.t_ns >= pulse_ns) else { return };
            self.index.waiting.pop_front();
            self.check_pulse(pulse_ns, after);
        }
    }

    /// Holds a pulse against the first counted frame after it.
    fn check_pulse(&mut self, pulse_ns: u64, after: usize) {
        let Some(Counted { frame, trigger: Some(trigger), step_ns, .. }) = self.counted.get(after) else {
            return;
        };
        let before = (frame.t_ns - pulse_ns) as f64 / step_ns;
        if !(before <= MOST_BEFORE) {
            return;
        }
        let turn = self.per_turn as f64;
        let at = (*trigger as f64 - before + 0.5 * turn).rem_euclid(turn) - 0.5 * turn;
        let (off, is_off) = match self.index.phase {
            Some(phase) => (at - phase, (at - phase).abs() > OFF_INDEX),
            None => (at.ceil(), !(-1.0 - OFF_STEPS..=OFF_STEPS).contains(&at)),
        };
        self.index.phase.get_or_insert(if is_off { at - off } else { at });
        let why = is_off.then(|| {
            format!(
                "its turn is void: the index pulse came {off:+.2} triggers off whole turns of {}: triggers were ignored or doubled",
                self.per_turn
            )
        });
        for counted in self.counted.iter_mut().take(after).filter(|counted| !counted.is_checked) {
            (counted.is_checked, counted.void) = (true, why.clone());
        }
        if is_off {
            self.count_anew(after, off.round() as i64);
        }
    }

    /// Counts the frames from one on from the index pulse before it.
    fn count_anew(&mut self, from: usize, off: i64) {
        let triggers = self.counted.iter_mut().skip(from).map(|counted| &mut counted.trigger);
        for trigger in triggers.chain(self.last.as_mut().map(|last| &mut last.1)) {
            *trigger = trigger.map(|trigger| trigger - off);
        }
    }

    /// The trigger that comes `steps` by time and `numbers` by number after another.
    fn after(&mut self, last: i64, numbers: f64, steps: f64) -> Option<i64> {
        let whole = steps.round();
        let is_stated = (steps - whole).abs() <= OFF_STEPS && whole <= MOST_STEPS.max(numbers);
        let next = is_stated.then_some(last + whole as i64);
        if !is_stated {
            let why = format!(
                "two frames lie {steps:.2} triggers apart by their times: how many came is not known; begin anew at an index pulse"
            );
            self.void_turns(last, last, &why);
        } else if whole != numbers {
            let what = if whole < numbers { "a trigger was doubled" } else { "a trigger was ignored" };
            let why = format!(
                "{what}: two frames lie {steps:.2} triggers apart by their times, {numbers} by their numbers"
            );
            self.void_turns(last, last + whole as i64, &why);
        }
        next
    }

    fn void_turns(&mut self, from: i64, to: i64, why: &str) {
        for turn in from.div_euclid(self.per_turn)..=to.div_euclid(self.per_turn) {
            self.void.push_back((turn, format!("turn {} is void: {why}", turn + 1)));
        }
        while self.void.len() > MOST_VOID {
            self.void.pop_front();
        }
    }

    /// Places of the next frames whose turns have ended, or of all that are left where `is_end`.
    pub fn decided(&mut self, is_end: bool) -> Vec<SampledPlace> {
        while is_end && !self.waiting.is_empty() {
            self.count_next();
        }
        self.check_index();
        let per_turn = self.per_turn;
        let turn = move |counted: &Counted| counted.trigger.map(|k| k.div_euclid(per_turn));
        let now = self.counted.back().and_then(turn);
        // where triggers are not known any more nothing is waited for
        let is_awaited = self.index.is_awaited;
        let is_over = |counted: &Counted| {
            is_end || now.is_none() || now > turn(counted) && (counted.is_checked || !is_awaited)
        };
        let ready = self.counted.iter().take_while(|counted| is_over(counted)).count();
        let ready: Vec<Counted> = self.counted.drain(..ready).collect();
        ready.iter().map(|counted| self.sampled_place(counted)).collect()
    }

    fn sampled_place(&self, counted: &Counted) -> SampledPlace {
        let place = self.place(counted);
        let u_deg = matches!(place, Place::At { .. }).then(|| self.u_deg(counted));
        SampledPlace { place, u_deg, z_mm: None }
    }

    /// Standard uncertainty of an angle, degrees: limits of uniform distributions (GUM 4.3.7) are
    /// half a count of trigger and of index, the part of the move to mid-exposure by which the
    /// speed is not known, and a quarter of a step where no index pulse has checked the count.
    fn u_deg(&self, counted: &Counted) -> f64 {
        let half_count_deg = 180.0 / f64::from(self.settings.counts_per_turn);
        let step_deg = 360.0 / self.per_turn as f64;
        let to_middle = self.settings.to_middle_ns(counted.frame.exposure_us) / counted.step_ns;
        let moved_deg = step_deg * counted.off_steps * to_middle;
        let unchecked_deg = if counted.is_checked { 0.0 } else { OFF_STEPS * step_deg };
        let limits = [half_count_deg, half_count_deg, moved_deg, unchecked_deg];
        (limits.iter().map(|limit| limit * limit).sum::<f64>() / 3.0).sqrt()
    }

    fn place(&self, counted: &Counted) -> Place {
        if let Some(why) = &counted.void {
            return Place::Void(why.clone());
        }
        if !(counted.step_ns > 0.0) {
            let why = "no rising times of it and its neighbours: a trigger that was ignored would not be seen, and the speed that \
                       moves its angle to mid-exposure is unknown";
            return Place::Void(why.to_owned());
        }
        let Some(trigger) = counted.trigger else {
            return Place::Void(
                "the number of its trigger is not known: triggers were missed before it; begin anew at an index pulse".to_owned(),
            );
        };
        if trigger < 0 {
            return Place::Void("no index pulse came before".to_owned());
        }
        let turn = trigger.div_euclid(self.per_turn);
        if let Some((_, why)) = self.void.iter().find(|(void, _)| *void == turn) {
            return Place::Void(why.clone());
        }
        let counts_a_step = f64::from(self.settings.counts_per_turn) / self.per_turn as f64;
        let sign = self.settings.forward(1) as f64;
        let speed = sign * counts_a_step / counted.step_ns;
        let exposure_us = counted.frame.exposure_us;
        let at = sign * trigger.rem_euclid(self.per_turn) as f64 * counts_a_step;
        let middle = at + speed * self.settings.to_middle_ns(exposure_us);
        let sweep_deg = 360.0 * speed * 1e3 * exposure_us / f64::from(self.settings.counts_per_turn);
        Place::At { angle_deg: self.settings.angle_deg(middle), sweep_deg }
    }
}

/// Time from a frame to the next, a trigger, by their numbers, ns.
fn time_a_trigger(before: &Triggered, frame: &Triggered) -> f64 {
    let numbers = frame.number.saturating_sub(before.number).max(1);
    frame.t_ns.saturating_sub(before.t_ns) as f64 / numbers as f64
}

#[cfg(test)]
mod tests {
    use super::super::encoder::{EncoderDirection, LatchedAt};
    use super::*;

    /// 600/min, 32 frames a turn, 2 ms of exposure.
    const FRAMES: u32 = 32;
    const PERIOD_NS: f64 = 3.125e6;
    const AMPLITUDE_MM: f64 = 0.005;
    const PHASE_DEG: f64 = 17.0;

    fn settings(latched_at: LatchedAt, direction: EncoderDirection) -> EncoderSettings {
        let frame_start_delay_us = if latched_at == LatchedAt::FrameStart { 150.0 } else { 0.0 };
        EncoderSettings {
            latched_at,
            direction,
            frame_start_delay_us,
            frames_per_turn: Some(FRAMES),
            ..EncoderSettings::new(4096)
        }
    }

    /// Frame at trigger `k` (from 0 at the index pulse), and what it shows of three lobes: the mean
    /// over its exposure by 500 instants.
    fn shown(settings: &EncoderSettings, k: f64) -> f64 {
        let sign = settings.forward(1) as f64;
        let middle_ns = k * PERIOD_NS + settings.to_middle_ns(2000.0);
        let at = |s: u32| {
            let t_ns = middle_ns + 2e6 * ((f64::from(s) + 0.5) / 500.0 - 0.5);
            let angle_deg = sign * 360.0 * t_ns / (PERIOD_NS * f64::from(FRAMES));
            AMPLITUDE_MM * (3.0 * (angle_deg - PHASE_DEG)).to_radians().cos()
        };
        (0..500).map(at).sum::<f64>() / 500.0
    }

    /// Frames of these triggers, some of them twice; numbers without gaps from 100 on, as cameras
    /// count frames.
    fn frames(triggers: &[i64]) -> Vec<Triggered> {
        let mut last = i64::MIN;
        let one = |(i, k): (usize, &i64)| {
            // a doubled trigger comes 0.3 ms after the first one
            let again = if *k == last { 3e5 } else { 0.0 };
            last = *k;
            let t_ns = (1e9 + *k as f64 * PERIOD_NS + again) as u64;
            Triggered { number: 100 + i as u64, t_ns, exposure_us: 2000.0 }
        };
        triggers.iter().enumerate().map(one).collect()
    }

    fn placed(settings: EncoderSettings, frames: &[Triggered]) -> Vec<Place> {
        let mut count = TriggerCount::new(settings, 100).unwrap();
        let mut places = Vec::new();
        for frame in frames {
            count.push(*frame);
            places.extend(count.decided(false));
        }
        places.extend(count.decided(true));
        assert_eq!((places.len(), count.undecided()), (frames.len(), 0));
        places.into_iter().map(|at| at.place).collect()
    }

    fn phase_deg(places: &[Place], shown: &[f64]) -> f64 {
        let (mut c, mut s) = (0.0, 0.0);
        for (place, h) in places.iter().zip(shown) {
            let Place::At { angle_deg, .. } = place else { continue };
            let (sin, cos) = (3.0 * angle_deg).to_radians().sin_cos();
            (c, s) = (c + h * cos, s + h * sin);
        }
        f64::atan2(s, c).to_degrees() / 3.0
    }

    #[test]
    fn three_lobes_have_their_phase_and_a_bad_trigger_voids_its_turn_and_shifts_nothing() {
        let whole: Vec<i64> = (0..128).collect();
        let ignored: Vec<i64> = whole.iter().copied().filter(|k| *k != 42).collect();
        let mut doubled = whole.clone();
        doubled.insert(43, 42);
        for latched_at in [LatchedAt::ExposureStart, LatchedAt::ExposureEnd, LatchedAt::FrameStart] {
            for direction in [EncoderDirection::Rising, EncoderDirection::Falling] {
                let settings = settings(latched_at, direction);
                for (triggers, word) in [(&whole, ""), (&ignored, "ignored"), (&doubled, "doubled")] {
                    let places = placed(settings, &frames(triggers));
                    let shown: Vec<f64> = triggers.iter().map(|k| shown(&settings, *k as f64)).collect();
                    let phase = phase_deg(&places, &shown);
                    assert!((phase - PHASE_DEG).abs() < 0.2, "{latched_at:?} {direction:?} {word}: {phase}");
                    for (place, k) in places.iter().zip(triggers) {
                        let is_void = !word.is_empty() && k.div_euclid(32) == 1;
                        match place {
                            Place::Void(why) => assert!(is_void && why.contains(word), "{k}: {why}"),
                            Place::At { sweep_deg, .. } => {
                                assert!(!is_void && (sweep_deg.abs() - 7.2).abs() < 1e-3, "{k} {word}");
                            }
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn lost_frames_are_triggers_and_what_the_times_do_not_state_is_void() {
        let settings = settings(LatchedAt::ExposureStart, EncoderDirection::Rising);
        let mut lost = frames(&(0..96).collect::<Vec<_>>());
        lost.drain(40..43);
        let places = placed(settings, &lost);
        assert!(places.iter().all(|place| matches!(place, Place::At { .. })));
        let Place::At { angle_deg, .. } = places[40] else { panic!("{:?}", places[40]) };
        // the 43rd trigger of 32 a turn, and half the sweep
        assert!((angle_deg - (11.0 * 11.25 + 3.6)).abs() < 1e-6, "{angle_deg}");
        // a pause of a hundred steps: the triggers after it are not known
        let paused: Vec<i64> = (0..40).chain(140..180).collect();
        let places = placed(settings, &frames(&paused));
        assert!(places[..32].iter().all(|place| matches!(place, Place::At { .. })));
        assert!(places[32..].iter().all(|place| matches!(place, Place::Void(_))), "{places:?}");
        // frames before the first one after the index pulse
        let mut early = TriggerCount::new(settings, 110).unwrap();
        frames(&(0..20).collect::<Vec<_>>()).into_iter().for_each(|frame| early.push(frame));
        let places: Vec<Place> = early.decided(true).into_iter().map(|at| at.place).collect();
        assert!(matches!(&places[9], Place::Void(why) if why.contains("index")));
        assert!(matches!(&places[10], Place::At { angle_deg, .. } if (angle_deg - 3.6).abs() < 1e-6));
        let without = EncoderSettings { frames_per_turn: None, ..settings };
        assert!(TriggerCount::new(without, 0).unwrap_err().contains("frames_per_turn"));
    }

    /// Places of frames at these triggers with these numbers and pulses, which are read every
    /// `a_look` frames.
    fn with_pulses(triggers: &[i64], numbers: &[i64], pulses: &[f64], a_look: usize) -> Vec<SampledPlace> {
        let settings = settings(LatchedAt::ExposureStart, EncoderDirection::Rising);
        let mut count = TriggerCount::new(settings, 0).unwrap().with_index();
        let mut pulses: VecDeque<u64> = pulses.iter().map(|k| (1e9 + k * PERIOD_NS) as u64).collect();
        let mut places = Vec::new();
        for (i, (k, number)) in triggers.iter().zip(numbers).enumerate() {
            let t_ns = (1e9 + *k as f64 * PERIOD_NS) as u64;
            count.push(Triggered { number: *number as u64, t_ns, exposure_us: 2000.0 });
            // pulses are read once in a while, of the time until then
            while i % a_look == 0 && pulses.front().is_some_and(|pulse| *pulse <= t_ns) {
                pulses.pop_front().into_iter().for_each(|pulse| count.index(pulse));
            }
            places.extend(count.decided(false));
        }
        pulses.into_iter().for_each(|pulse| count.index(pulse));
        places.extend(count.decided(true));
        places
    }

    #[test]
    fn every_index_pulse_checks_the_count_and_an_unchecked_turn_is_in_u() {
        let all: Vec<i64> = (0..112).collect();
        for a_look in [1, 40] {
            let places = with_pulses(&all, &all, &[-0.4, 31.6, 63.6, 95.6], a_look);
            assert_eq!(places.len(), 112);
            for (k, at) in places.iter().enumerate() {
                let Place::At { angle_deg, .. } = at.place else { panic!("{k}: {:?}", at.place) };
                let right = (k as f64 * 11.25 + 3.6).rem_euclid(360.0);
                assert!((angle_deg - right).abs() < 1e-6, "{k}: {angle_deg}");
                let u_deg = at.u_deg.unwrap();
                // 4096 counts: √2·0.088°/√12; without a pulse after it 2.8° by √3
                let right = if k < 96 { 0.0359 } else { 1.6243 };
                assert!((u_deg - right).abs() < 0.001, "{k}: {u_deg}");
            }
        }
        // the second pulse comes one trigger late: the count is wrong since the first one
        let places = with_pulses(&all, &all, &[-0.4, 31.6, 64.6, 96.6], 1);
        for (k, at) in places.iter().enumerate() {
            match &at.place {
                Place::Void(why) => {
                    assert!((32..65).contains(&k) && why.contains("+1.00 triggers off"), "{k}: {why}");
                }
                Place::At { angle_deg, .. } => {
                    let since = if k < 65 { k } else { k - 65 };
                    let right = (since as f64 * 11.25 + 3.6).rem_euclid(360.0);
                    assert!((angle_deg - right).abs() < 1e-6 && !(32..65).contains(&k), "{k}: {angle_deg}");
                }
            }
        }
        // FIRST itself is wrong by three
        let places = with_pulses(&all, &all, &[2.6, 34.6], 1);
        assert!(places[..3].iter().all(|at| matches!(&at.place, Place::Void(_))));
        assert!(matches!(places[3].place, Place::At { angle_deg, .. } if (angle_deg - 3.6).abs() < 1e-6));
    }
}
