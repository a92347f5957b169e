//! Counts of the frames of a scan to angles at mid-exposure.
//!
//! ```text
//! φ = φ_index + 360°·(c − c_index)/N + ω·τ
//! ```
//!
//! c counts in the sense of the angle, N counts a turn, τ from the latch to the middle of the
//! exposure, ω from the frames before and after at constant speed between them.
//!
//! Where the encoder triggers frames equally spaced, neighbours that lie another step apart have a
//! trigger between them that was ignored or doubled: their turns are void. A step is never made up
//! for, because which of two frames is the wrong one cannot be seen.

use super::encoder::EncoderSettings;

/// What a frame's row states.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Latched {
    /// The count.
    pub count: i64,
    /// The count at the last index pulse, where it is recorded.
    pub index: Option<i64>,
    /// Start of exposure on the device's clock, ns; none where it is not recorded.
    pub t_ns: Option<u64>,
    /// Exposure, µs.
    pub exposure_us: f64,
}

/// Where the spindle stood at the middle of a frame's exposure.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// At an angle.
    At {
        /// Spindle angle, degrees, 0 to below 360.
        angle_deg: f64,
        /// Angle that the spindle turned during the exposure, degrees.
        sweep_deg: f64,
    },
    /// In a turn that is void, and why.
    Void(String),
}

/// Share of a step by which two triggered frames may lie off it: a missing or doubled one is off by
/// a whole step, so that half a step separates the two.
const OFF_STEP: f64 = 0.5;

/// Places of the frames of one scan, in the order in which they were taken.
///
/// # Errors
/// An encoder that counts backwards, by the number of the frame (from 0) at which it does; a frame
/// that moves during its exposure while no time is stated.
pub fn bind(settings: &EncoderSettings, frames: &[Latched]) -> Result<Vec<Place>, (usize, String)> {
    let counts: Vec<i64> = frames.iter().map(|f| settings.forward(f.count)).collect();
    only_forward(settings, &counts, frames)?;
    let index: Vec<Option<i64>> = frames.iter().map(|f| f.index.map(|i| settings.forward(i))).collect();
    let turns = i64::from(settings.counts_per_turn);
    let zero = index.iter().flatten().next().copied().unwrap_or(0);
    let turn_of = |i: usize| (counts[i] - zero).div_euclid(turns);
    let void = void_turns(settings, &counts, &index, turn_of);
    let mut places = Vec::with_capacity(frames.len());
    for (i, frame) in frames.iter().enumerate() {
        if let Some((_, why)) = void.iter().find(|(turn, _)| *turn == turn_of(i)) {
            places.push(Place::Void(why.clone()));
            continue;
        }
        let speed = counts_per_ns(&counts, frames, i).map_err(|why| (i, why))?;
        let since = (counts[i] - index[i].unwrap_or(zero)) as f64;
        let middle = since + speed * settings.to_middle_ns(frame.exposure_us);
        let sweep = 360.0 * speed * 1e3 * frame.exposure_us / f64::from(settings.counts_per_turn);
        places.push(Place::At { angle_deg: settings.angle_deg(middle), sweep_deg: sweep });
    }
    Ok(places)
}

/// Refuses counts that go against the stated direction by more than the index may jitter.
fn only_forward(
    settings: &EncoderSettings,
    counts: &[i64],
    frames: &[Latched],
) -> Result<(), (usize, String)> {
    let back = |pair: &[i64]| pair[1] < pair[0] - i64::from(settings.index_tolerance_counts);
    let Some(i) = counts.windows(2).position(back) else { return Ok(()) };
    let (rises, other) = match settings.direction.sign() {
        1 => ("rise", "falling"),
        _ => ("fall", "rising"),
    };
    Err((
        i + 1,
        format!(
            "the encoder counts backwards: {} after {}, where counts must {rises} (direction); state direction = \"{other}\" or \
             record one turn at a time",
            frames[i + 1].count,
            frames[i].count
        ),
    ))
}

/// Turns that are void, each with its first reason.
fn void_turns(
    settings: &EncoderSettings,
    counts: &[i64],
    index: &[Option<i64>],
    turn_of: impl Fn(usize) -> i64,
) -> Vec<(i64, String)> {
    let mut void: Vec<(i64, String)> = Vec::new();
    let mut add = |turns: std::ops::RangeInclusive<i64>, why: String| {
        void.extend(turns.map(|turn| (turn, format!("turn {} is void: {why}", turn + 1))));
    };
    for i in 1..counts.len() {
        let turns = turn_of(i - 1)..=turn_of(i);
        if let Some(why) = off_step(settings, counts[i] - counts[i - 1]) {
            add(turns.clone(), why);
        }
        let (Some(before), Some(after)) = (index[i - 1], index[i]) else { continue };
        if let Some(why) = off_index(settings, after - before) {
            // the count went wrong somewhere between the two pulses
            add(turn_of(i - 1).saturating_sub(1)..=turn_of(i), why);
        }
    }
    void
}

/// Why two triggered frames that lie `counts` apart are no neighbours.
fn off_step(settings: &EncoderSettings, counts: i64) -> Option<String> {
    let frames = f64::from(settings.frames_per_turn?);
    let step = f64::from(settings.counts_per_turn) / frames;
    let steps = counts as f64 / step;
    if (steps - 1.0).abs() <= OFF_STEP {
        return None;
    }
    let what = if steps < 1.0 { "a trigger was doubled" } else { "a trigger was ignored" };
    Some(format!("{what}, two frames lie {counts} counts apart where {step:.1} are due"))
}

/// Why two index pulses that lie `counts` apart contradict the count.
pub(super) fn off_index(settings: &EncoderSettings, counts: i64) -> Option<String> {
    let turn = i64::from(settings.counts_per_turn);
    let off = (counts + turn / 2).rem_euclid(turn) - turn / 2;
    (off.abs() > i64::from(settings.index_tolerance_counts)).then(|| {
        format!("the index pulse came {off:+} counts off whole turns of {turn}: counts were lost or added")
    })
}

/// Speed about frame `i` by its neighbours' times, counts a ns; 0 for a frame without exposure.
fn counts_per_ns(counts: &[i64], frames: &[Latched], i: usize) -> Result<f64, String> {
    let (a, b) = (i.saturating_sub(1), (i + 1).min(frames.len() - 1));
    // held at every angle: a step between two frames is no speed where no exposure is stated
    if frames[i].exposure_us == 0.0 || counts[a] == counts[b] {
        return Ok(0.0);
    }
    let times = frames[a].t_ns.zip(frames[b].t_ns).filter(|(a, b)| b > a);
    let Some((from, to)) = times else {
        return Err(
            "its exposure is stated, but no rising t_ns of it and its neighbours: the speed that moves the angle to mid-exposure is unknown"
                .to_owned(),
        );
    };
    Ok((counts[b] - counts[a]) as f64 / (to - from) as f64)
}

/// Places by the number of the trigger alone: frame k after an index pulse stands at k steps.
/// `first_after_index` states of every frame whether an index pulse came since the frame before.
/// Frames before the first pulse, and those of turns with another number of frames, are void.
pub fn bind_triggers(
    settings: &EncoderSettings,
    frames_per_turn: u32,
    first_after_index: &[bool],
) -> Vec<Place> {
    let mut places = Vec::with_capacity(first_after_index.len());
    let starts: Vec<usize> = (0..first_after_index.len()).filter(|i| first_after_index[*i]).collect();
    let before = starts.first().copied().unwrap_or(first_after_index.len());
    places.extend((0..before).map(|_| Place::Void("no index pulse came before".to_owned())));
    for (number, start) in starts.iter().enumerate() {
        let end = starts.get(number + 1).copied().unwrap_or(first_after_index.len());
        let found = end - start;
        let is_last = end == first_after_index.len();
        let whole = found == frames_per_turn as usize;
        places.extend((0..found).map(|k| match whole {
            true => {
                let counts = k as f64 * f64::from(settings.counts_per_turn) / f64::from(frames_per_turn);
                Place::At { angle_deg: settings.angle_deg(counts), sweep_deg: 0.0 }
            }
            false if is_last && found < frames_per_turn as usize => {
                Place::Void(format!("turn {} is void: it ends after {found} frames", number + 1))
            }
            false => Place::Void(format!(
                "turn {} is void: {found} frames between two index pulses, {frames_per_turn} are due",
                number + 1
            )),
        }));
    }
    places
}

#[cfg(test)]
mod tests {
    use super::super::encoder::{EncoderDirection, LatchedAt};
    use super::super::smear::{attenuation, corrected_amplitude_mm};
    use super::*;

    const COUNTS: u32 = 4096;
    const FRAMES: u32 = 32;
    const PER_MIN: f64 = 600.0;
    const EXPOSURE_US: f64 = 2000.0;
    const AMPLITUDE_MM: f64 = 0.005;
    const PHASE_DEG: f64 = 17.0;

    fn settings(latched_at: LatchedAt) -> EncoderSettings {
        EncoderSettings { latched_at, frames_per_turn: Some(FRAMES), ..EncoderSettings::new(COUNTS) }
    }

    /// Counts a ns at [`PER_MIN`].
    fn speed() -> f64 {
        f64::from(COUNTS) * PER_MIN / 6e10
    }

    /// Frames of two turns at 600/min, and what each shows of a three-lobed part: the mean of its
    /// radius over the exposure by 2000 instants.
    fn turning(settings: &EncoderSettings) -> (Vec<Latched>, Vec<f64>) {
        let period_ns = 6e10 / PER_MIN / f64::from(FRAMES);
        let one = |i: u32| {
            let start_ns = 1e9 + f64::from(i) * period_ns;
            let latch_ns = start_ns
                + match settings.latched_at {
                    LatchedAt::ExposureStart => 0.0,
                    LatchedAt::ExposureEnd => 1e3 * EXPOSURE_US,
                    LatchedAt::FrameStart => -1e3 * settings.frame_start_delay_us,
                };
            let count = (latch_ns * speed()).floor() as i64;
            let index = count.div_euclid(i64::from(COUNTS)) * i64::from(COUNTS);
            let sign = settings.direction.sign();
            let frame = Latched {
                count: sign * count,
                index: Some(sign * index),
                t_ns: Some(start_ns as u64),
                exposure_us: EXPOSURE_US,
            };
            let at = |s: u32| {
                let t = start_ns + 1e3 * EXPOSURE_US * (f64::from(s) + 0.5) / 2000.0;
                let angle_deg = 360.0 * t * speed() / f64::from(COUNTS);
                AMPLITUDE_MM * (3.0 * (angle_deg - PHASE_DEG)).to_radians().cos()
            };
            (frame, (0..2000).map(at).sum::<f64>() / 2000.0)
        };
        (0..2 * FRAMES).map(one).unzip()
    }

    /// Amplitude and phase (degrees of the part) of the third harmonic.
    fn third(places: &[Place], shown: &[f64]) -> (f64, f64) {
        let (mut c, mut s, mut n) = (0.0, 0.0, 0.0);
        for (place, h) in places.iter().zip(shown) {
            let Place::At { angle_deg, .. } = place else { continue };
            let (sin, cos) = (3.0 * angle_deg).to_radians().sin_cos();
            (c, s, n) = (c + h * cos, s + h * sin, n + 1.0);
        }
        (2.0 * c.hypot(s) / n, s.atan2(c).to_degrees() / 3.0)
    }

    #[test]
    fn the_phase_of_three_lobes_is_right_whatever_the_latch() {
        for latched_at in [LatchedAt::ExposureStart, LatchedAt::ExposureEnd, LatchedAt::FrameStart] {
            for direction in [EncoderDirection::Rising, EncoderDirection::Falling] {
                let delay = if latched_at == LatchedAt::FrameStart { 150.0 } else { 0.0 };
                let settings =
                    EncoderSettings { direction, frame_start_delay_us: delay, ..settings(latched_at) };
                settings.validate().unwrap();
                let (frames, shown) = turning(&settings);
                let places = bind(&settings, &frames).unwrap();
                let (amplitude, phase) = third(&places, &shown);
                assert!((phase - PHASE_DEG).abs() < 0.2, "{latched_at:?} {direction:?}: {phase}");
                // 7.2° of sweep take a little from three lobes, and it is given back
                let sweep = 7.2_f64.to_radians();
                assert!((amplitude / AMPLITUDE_MM - attenuation(3, sweep)).abs() < 2e-3);
                let restored = corrected_amplitude_mm(3, amplitude, sweep).unwrap();
                assert!((restored / AMPLITUDE_MM - 1.0).abs() < 2e-3, "{restored}");
                let Place::At { sweep_deg, .. } = places[5] else { panic!("{:?}", places[5]) };
                assert!((sweep_deg - 7.2).abs() < 0.1, "{sweep_deg}");
            }
        }
        // with the latch stated wrongly the phase is off by half the sweep: the test can fail
        let (frames, shown) = turning(&settings(LatchedAt::ExposureStart));
        let wrong = bind(&settings(LatchedAt::ExposureEnd), &frames).unwrap();
        assert!((third(&wrong, &shown).1 - PHASE_DEG).abs() > 3.0);
    }

    #[test]
    fn a_trigger_ignored_or_doubled_voids_its_turn_and_shifts_nothing() {
        for latched_at in [LatchedAt::ExposureStart, LatchedAt::ExposureEnd] {
            let settings = settings(latched_at);
            let (whole, _) = turning(&settings);
            let right = bind(&settings, &whole).unwrap();
            assert!(right.iter().all(|p| matches!(p, Place::At { .. })));
            let mut ignored = whole.clone();
            ignored.remove(10);
            let mut doubled = whole.clone();
            doubled.insert(10, whole[10]);
            for (frames, word) in [(ignored, "ignored"), (doubled, "doubled")] {
                let places = bind(&settings, &frames).unwrap();
                let at = |i: usize| frames[i].count.div_euclid(i64::from(COUNTS));
                let first = at(10);
                for (i, place) in places.iter().enumerate() {
                    match place {
                        Place::Void(why) => assert!(at(i) == first && why.contains(word), "{i}: {why}"),
                        Place::At { .. } => assert!(at(i) != first, "{word}: {i} stands in the void turn"),
                    }
                }
                // the frames of the other turn stand where they stood
                assert_eq!(places.last(), right.last());
            }
        }
    }

    #[test]
    fn an_index_pulse_that_contradicts_the_count_voids_the_turns_about_it() {
        let settings = EncoderSettings { frames_per_turn: None, ..settings(LatchedAt::ExposureStart) };
        let (mut frames, _) = turning(&settings);
        // five counts are lost in the first turn: the later counts and pulses lie lower
        let late = frames.iter().position(|f| f.index != frames[0].index).unwrap();
        frames[late..].iter_mut().for_each(|f| {
            f.count -= 5;
            f.index = f.index.map(|i| i - 5);
        });
        let places = bind(&settings, &frames).unwrap();
        assert!(matches!(&places[late - 1], Place::Void(why) if why.contains("-5 counts")), "{places:?}");
        // a jitter of one count is none
        frames[late..].iter_mut().for_each(|f| {
            f.count += 4;
            f.index = f.index.map(|i| i + 4);
        });
        assert!(bind(&settings, &frames).unwrap().iter().all(|p| matches!(p, Place::At { .. })));
    }

    #[test]
    fn an_encoder_that_counts_backwards_is_refused_by_its_counts() {
        let rising = settings(LatchedAt::ExposureStart);
        let (frames, _) = turning(&rising);
        let falling = EncoderSettings { direction: EncoderDirection::Falling, ..rising };
        let (at, why) = bind(&falling, &frames).unwrap_err();
        assert!(at == 1 && why.contains("counts backwards") && why.contains("rising"), "{at} {why}");
        // frames that stand: no time is needed
        let held: Vec<Latched> = (0..4).map(|i| Latched { count: 1024 * i, ..Latched::default() }).collect();
        let still = EncoderSettings::new(COUNTS);
        let angles: Vec<Place> = bind(&still, &held).unwrap();
        assert_eq!(angles[3], Place::At { angle_deg: 270.0, sweep_deg: 0.0 });
        let untimed: Vec<Latched> = held.iter().map(|f| Latched { exposure_us: 100.0, ..*f }).collect();
        assert!(bind(&still, &untimed).unwrap_err().1.contains("t_ns"));
        assert_eq!(bind(&still, &[]).unwrap(), Vec::new());
    }

    #[test]
    fn triggers_are_counted_between_index_pulses() {
        let settings = EncoderSettings::new(COUNTS);
        let turn = |n: usize| (0..n).map(|k| k == 0);
        let pulses: Vec<bool> =
            [false, false].into_iter().chain(turn(4)).chain(turn(3)).chain(turn(4)).collect();
        let places = bind_triggers(&settings, 4, &pulses);
        let angle = |p: &Place| match p {
            Place::At { angle_deg, .. } => Some(*angle_deg),
            Place::Void(_) => None,
        };
        let found: Vec<Option<f64>> = places.iter().map(angle).collect();
        let whole = [0.0, 90.0, 180.0, 270.0].map(Some);
        let due: Vec<Option<f64>> =
            [None; 2].into_iter().chain(whole).chain([None; 3]).chain(whole).collect();
        assert_eq!(found, due);
        let doubled: Vec<bool> = turn(5).chain(turn(4)).collect();
        assert_eq!(bind_triggers(&settings, 4, &doubled).iter().filter_map(angle).count(), 4);
    }
}
