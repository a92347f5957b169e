//! Frames between timed samples of an encoder.
//!
//! ```text
//! φ = φ_index + 360°·(c(t + τ) − c_index)/N
//! ```
//!
//! c is interpolated between the samples about mid-exposure t + τ, where t is the instant of the
//! frame that its time is of (`latched_at`), and likewise at both ends of the exposure: their
//! difference is the sweep. Every index pulse checks the count: where two lie no whole turns apart,
//! the time between them is void, because it cannot be seen when the count went wrong.

use super::binding::{Place, off_index};
use super::encoder::EncoderSettings;
use super::interpolation::{Sample, interpolated};

/// Largest limit of an angle's error by acceleration between samples, degrees: beyond it the
/// samples are too sparse for the phase of a form.
const MOST_BEND_DEG: f64 = 0.2;
/// Most of a turn between two samples: over more of it, speed that varies once a turn passes unseen
/// through the second differences.
const MOST_TURNED: f64 = 0.25;
/// Longest time between two samples, ns: beyond it a spindle may have stopped and gone on.
const LONGEST_NS: u64 = 1_000_000_000;
/// Most samples that are kept, 16 MB of each axis. Of more the older half is let go.
const MOST: usize = 1 << 20;
/// Most spans of void time that are kept: a count that goes wrong more often is of no use.
const MOST_VOID: usize = 256;

/// A sample of the encoder, and of the carriage where it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncoderSample {
    /// When, ns.
    pub t_ns: u64,
    /// The count.
    pub count: i64,
    /// The count at the last index pulse, where it is recorded.
    pub index: Option<i64>,
    /// Carriage position, mm, where it is recorded.
    pub z_mm: Option<f64>,
}

/// The exposure of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposure {
    /// Time of the frame, ns, on the clock of the samples, at the instant `latched_at`.
    pub t_ns: u64,
    /// Exposure time, µs; `None` where it is not known.
    pub exposure_us: Option<f64>,
}

/// Where a frame was exposed.
#[derive(Clone, Debug, PartialEq)]
pub struct SampledPlace {
    /// Spindle angle.
    pub place: Place,
    /// Standard uncertainty of the angle, degrees, by acceleration between the samples and the
    /// resolution of the count and of its index; `None` of a void place.
    pub u_deg: Option<f64>,
    /// Carriage position at mid-exposure, mm; `None` where the samples have none.
    pub z_mm: Option<f64>,
}

/// An encoder by its samples, which come in the order of their times.
#[derive(Clone, Debug)]
pub struct SampledEncoder {
    settings: EncoderSettings,
    /// Counts in the sense of the angle.
    counts: Vec<Sample>,
    z_mm: Vec<Sample>,
    /// Counts at index pulses with the time of the first sample that has each.
    pulses: Vec<(u64, i64)>,
    void: Vec<(u64, u64, String)>,
    has_index: bool,
}

impl SampledEncoder {
    /// No sample yet.
    pub fn new(settings: EncoderSettings) -> Self {
        let (counts, z_mm, pulses, void) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { settings, counts, z_mm, pulses, void, has_index: false }
    }

    /// One more sample.
    ///
    /// # Errors
    /// A time that does not rise, counts against the stated direction: the sample is left out.
    pub fn push(&mut self, sample: EncoderSample) -> Result<(), String> {
        let EncoderSample { t_ns, count, index, z_mm } = sample;
        let value = self.settings.forward(count) as f64;
        if let Some(last) = self.counts.last() {
            if last.t_ns >= t_ns {
                return Err(format!("t_ns {t_ns} does not rise"));
            }
            if value < last.value - f64::from(self.settings.index_tolerance_counts) {
                return Err(format!(
                    "the encoder counts backwards: {count} at t_ns {t_ns}; state the other direction, or record one sense of rotation"
                ));
            }
        }
        self.let_go();
        self.counts.push(Sample { t_ns, value });
        self.z_mm.extend(z_mm.map(|value| Sample { t_ns, value }));
        if let Some(index) = index.map(|index| self.settings.forward(index)) {
            self.pulse(t_ns, index);
        }
        Ok(())
    }

    /// The count at the last index pulse, as a sample has it.
    fn pulse(&mut self, t_ns: u64, index: i64) {
        self.has_index = true;
        match self.pulses.last() {
            Some((_, known)) if *known == index => return,
            Some((since_ns, known)) => {
                if let Some(why) = off_index(&self.settings, index - known) {
                    self.void.push((*since_ns, t_ns, why));
                }
            }
            None => {}
        }
        self.pulses.push((t_ns, index));
    }

    fn let_go(&mut self) {
        for samples in [&mut self.counts, &mut self.z_mm] {
            if samples.len() == MOST {
                samples.drain(..MOST / 2);
            }
        }
        if self.pulses.len() == MOST {
            self.pulses.drain(..MOST / 2);
        }
        if self.void.len() == MOST_VOID {
            self.void.drain(..MOST_VOID / 2);
        }
    }

    /// Time of the last sample, ns.
    pub fn last_ns(&self) -> Option<u64> {
        self.counts.last().map(|last| last.t_ns)
    }

    /// Whether the samples reach beyond the exposure.
    pub fn covers(&self, exposure: &Exposure) -> bool {
        let [_, _, end_ns] = self.instants(exposure);
        self.last_ns().is_some_and(|last| last >= end_ns)
    }

    /// Whether an index pulse after the exposure has checked its count; without index pulses, and
    /// at a spindle that has stood since, there is nothing to be checked.
    pub fn is_checked(&self, exposure: &Exposure) -> bool {
        let [start_ns, _, end_ns] = self.instants(exposure);
        let since = self.counts.partition_point(|s| s.t_ns <= start_ns).saturating_sub(1);
        let ends = self.counts.get(since).zip(self.counts.last());
        let stands = ends.is_some_and(|(from, last)| (last.value - from.value).abs() < 1.0);
        !self.has_index || stands || self.pulses.last().is_some_and(|(t_ns, _)| *t_ns > end_ns)
    }

    /// Where a frame was exposed.
    pub fn place(&self, exposure: &Exposure) -> SampledPlace {
        let [_, middle_ns, _] = self.instants(exposure);
        let z_mm = interpolated(&self.z_mm, middle_ns, LONGEST_NS).ok().map(|(z_mm, _)| z_mm);
        match self.angle(exposure) {
            Ok((place, u_deg)) => SampledPlace { place, u_deg: Some(u_deg), z_mm },
            Err(why) => SampledPlace { place: Place::Void(why), u_deg: None, z_mm },
        }
    }

    /// The angle, and its standard uncertainty, degrees.
    fn angle(&self, exposure: &Exposure) -> Result<(Place, f64), String> {
        let [start_ns, middle_ns, end_ns] = self.instants(exposure);
        if let Some((.., why)) = self.void.iter().find(|(from, to, _)| start_ns <= *to && end_ns >= *from) {
            return Err(format!("its turn is void: {why}"));
        }
        let (count, limit_deg) = self.count(middle_ns)?;
        let zero = match self.pulses.iter().rev().find(|(t_ns, _)| *t_ns <= middle_ns) {
            Some((_, index)) => *index,
            None if self.has_index => return Err("no index pulse came before".to_owned()),
            None => 0,
        };
        let turn = f64::from(self.settings.counts_per_turn);
        let sweep_deg = 360.0 * (self.count(end_ns)?.0 - self.count(start_ns)?.0) / turn;
        if exposure.exposure_us.is_none() && !self.stands(middle_ns) {
            return Err("the spindle turns, and the exposure time of the frame is not stated".to_owned());
        }
        // rectangular: the limit by acceleration, and a whole count of the sample and of the index
        let u_deg = (limit_deg.powi(2) / 3.0 + 2.0 * (360.0 / turn).powi(2) / 12.0).sqrt();
        Ok((Place::At { angle_deg: self.settings.angle_deg(count - zero as f64), sweep_deg }, u_deg))
    }

    /// The count at a time, and the limit of its error by acceleration, degrees.
    fn count(&self, t_ns: u64) -> Result<(f64, f64), String> {
        let (count, limit) = interpolated(&self.counts, t_ns, LONGEST_NS)?;
        let turn = f64::from(self.settings.counts_per_turn);
        let turned = self.about(t_ns).map_or(0.0, |(a, b)| (b.value - a.value) / turn);
        if turned > MOST_TURNED {
            return Err(format!(
                "the spindle turned by {:.0}° between two samples, {:.0}° at most: sample the encoder faster",
                360.0 * turned,
                360.0 * MOST_TURNED
            ));
        }
        let limit_deg = 360.0 * limit / turn;
        if limit_deg > MOST_BEND_DEG {
            return Err(format!(
                "the speed changes between samples: its angle is known to {limit_deg:.2}° only, {MOST_BEND_DEG}° at most; sample \
                 the encoder faster"
            ));
        }
        Ok((count, limit_deg))
    }

    /// The samples before and after a time.
    fn about(&self, t_ns: u64) -> Option<(&Sample, &Sample)> {
        let after = self.counts.partition_point(|s| s.t_ns < t_ns);
        self.counts.get(after.checked_sub(1)?).zip(self.counts.get(after))
    }

    fn stands(&self, t_ns: u64) -> bool {
        self.about(t_ns).is_none_or(|(a, b)| a.value == b.value)
    }

    /// Start, middle and end of an exposure, ns.
    fn instants(&self, exposure: &Exposure) -> [u64; 3] {
        let exposure_us = exposure.exposure_us.unwrap_or(0.0);
        let middle = exposure.t_ns as i128 + self.settings.to_middle_ns(exposure_us).round() as i128;
        let half = (0.5e3 * exposure_us).round() as i128;
        [middle - half, middle, middle + half].map(|t| u64::try_from(t).unwrap_or(0))
    }
}

#[cfg(test)]
mod tests {
    use super::super::encoder::{EncoderDirection, LatchedAt};
    use super::*;

    const TURN: u32 = 4096;
    const MS: u64 = 1_000_000;

    /// Samples each millisecond at 600/min, 40.96 counts apart, the count cut off to whole ones.
    fn samples(settings: EncoderSettings, from_ms: u64, to_ms: u64, lost: i64) -> SampledEncoder {
        let mut encoder = SampledEncoder::new(settings);
        add(&mut encoder, from_ms..to_ms, lost);
        encoder
    }

    fn add(encoder: &mut SampledEncoder, ms: std::ops::Range<u64>, lost: i64) {
        let sign = encoder.settings.direction.sign();
        for t in ms {
            let count = (40.96 * t as f64).floor() as i64;
            let index = count.div_euclid(i64::from(TURN)) * i64::from(TURN);
            // counts that are lost in the second turn are missing from then on
            let (count, index) = (
                if t > 150 { count - lost } else { count },
                if index > i64::from(TURN) { index - lost } else { index },
            );
            let sample = EncoderSample {
                t_ns: t * MS,
                count: sign * count,
                index: Some(sign * index),
                z_mm: Some(5.0 + 0.01 * t as f64),
            };
            encoder.push(sample).unwrap();
        }
    }

    fn angle(place: &SampledPlace) -> Result<f64, &str> {
        match &place.place {
            Place::At { angle_deg, .. } => Ok(*angle_deg),
            Place::Void(why) => Err(why),
        }
    }

    #[test]
    fn angle_sweep_and_carriage_are_those_at_mid_exposure_whatever_the_latch_and_the_direction() {
        for (latched_at, to_middle_us) in [
            (LatchedAt::ExposureStart, 1000.0),
            (LatchedAt::ExposureEnd, -1000.0),
            (LatchedAt::FrameStart, 1150.0),
        ] {
            for direction in [EncoderDirection::Rising, EncoderDirection::Falling] {
                let frame_start_delay_us = if latched_at == LatchedAt::FrameStart { 150.0 } else { 0.0 };
                let settings = EncoderSettings {
                    latched_at,
                    direction,
                    frame_start_delay_us,
                    ..EncoderSettings::new(TURN)
                };
                let encoder = samples(settings, 0, 400, 0);
                for k in 3..40 {
                    let exposure = Exposure { t_ns: k * 7_123_457, exposure_us: Some(2000.0) };
                    let found = encoder.place(&exposure);
                    let middle_ms = 1e-6 * exposure.t_ns as f64 + 1e-3 * to_middle_us;
                    let due = (3.6 * middle_ms).rem_euclid(360.0);
                    let off = (angle(&found).unwrap() - due + 180.0).rem_euclid(360.0) - 180.0;
                    // a count is 0.088°
                    assert!(off.abs() < 0.1, "{latched_at:?} {direction:?} {k}: {off}");
                    assert!((found.z_mm.unwrap() - 5.0 - 0.01 * middle_ms).abs() < 1e-6);
                    let Place::At { sweep_deg, .. } = found.place else { panic!("{k}") };
                    assert!((sweep_deg - 7.2).abs() < 0.1, "{sweep_deg}");
                }
            }
        }
    }

    #[test]
    fn counts_lost_between_two_pulses_void_that_time_alone() {
        let encoder = samples(EncoderSettings::new(TURN), 0, 500, 7);
        let at = |ms: u64| encoder.place(&Exposure { t_ns: ms * MS, exposure_us: Some(500.0) });
        let due = |ms: u64| (3.6 * (ms as f64 + 0.25)).rem_euclid(360.0);
        for ms in [20, 90, 320, 440] {
            assert!((angle(&at(ms)).unwrap() - due(ms)).abs() < 0.1, "{ms}");
        }
        for ms in [105, 149, 180, 199] {
            let found = at(ms);
            let why = angle(&found).unwrap_err();
            assert!(why.contains("void") && why.contains("-7 counts"), "{ms}: {why}");
        }
    }

    #[test]
    fn what_the_samples_do_not_show_is_no_angle() {
        let encoder = samples(EncoderSettings::new(TURN), 0, 50, 0);
        let at = |ms: u64, exposure_us| encoder.place(&Exposure { t_ns: ms * MS, exposure_us });
        assert!(angle(&at(60, Some(10.0))).unwrap_err().contains("after the last"));
        assert!(angle(&at(20, None)).unwrap_err().contains("exposure time"));
        assert!(!encoder.covers(&Exposure { t_ns: 49 * MS, exposure_us: Some(10.0) }));
        assert!(encoder.covers(&Exposure { t_ns: 48 * MS, exposure_us: Some(10.0) }));
        let sample = |t_ns, count| EncoderSample { t_ns, count, index: None, z_mm: None };
        let mut sparse = SampledEncoder::new(EncoderSettings::new(TURN));
        (0..4).for_each(|k| sparse.push(sample(100 * MS * k, 2000 * k as i64)).unwrap());
        let found = sparse.place(&Exposure { t_ns: 150 * MS, exposure_us: Some(10.0) });
        assert!(angle(&found).unwrap_err().contains("sample the encoder faster"));
        // a spindle that starts: 41 counts a millisecond from one sample to the next
        let mut starts = SampledEncoder::new(EncoderSettings::new(TURN));
        for k in 0..40 {
            starts.push(sample(MS * k, 60 * (k as i64 - 20).max(0))).unwrap();
        }
        let found = starts.place(&Exposure { t_ns: 20 * MS + MS / 2, exposure_us: Some(10.0) });
        assert!(angle(&found).unwrap_err().contains("speed changes"));
        assert!(starts.push(sample(MS * 40, 10)).unwrap_err().contains("counts backwards"));
        assert!(starts.push(sample(MS * 39, 10)).unwrap_err().contains("does not rise"));
    }

    #[test]
    fn a_turn_waits_for_the_pulse_that_checks_it() {
        let mut encoder = samples(EncoderSettings::new(TURN), 0, 95, 0);
        let exposure = Exposure { t_ns: 20 * MS, exposure_us: Some(500.0) };
        assert!(encoder.covers(&exposure) && !encoder.is_checked(&exposure));
        add(&mut encoder, 95..110, 0);
        assert!(encoder.is_checked(&exposure));
        let settings = EncoderSettings::new(TURN);
        let mut rest = SampledEncoder::new(settings);
        for t in 0..30 {
            rest.push(EncoderSample { t_ns: t * MS, count: 77, index: Some(0), z_mm: None }).unwrap();
        }
        let found = rest.place(&Exposure { t_ns: 10 * MS, exposure_us: None });
        assert!(rest.is_checked(&exposure) && (angle(&found).unwrap() - 77.0 * 360.0 / 4096.0).abs() < 1e-9);
    }
}
