//! Whether a diameter has settled: readings seconds apart agree, or a trend is named.
//!
//! Coolant that runs off and a part that cools change the diameter from frame to frame in one
//! sense. Over the readings of the last `settle_s` seconds a line is fitted by least squares; its
//! slope b with the standard error s_b of the residuals is a trend where
//!
//! ```text
//! |b|/s_b > t(1 − α/2, n − 2)
//! ```
//!
//! Student's t at the two-sided false alarm α = 1 % a test (a steady diameter waits in vain once in
//! a hundred readings). What remains undetected is carried into U: half the window's change by the
//! largest slope that the same test would accept, |b| + t·s_b, as the limit of a uniform
//! distribution. Readings of a turning part are means of whole turns, so that lobes are no trend.

use std::collections::VecDeque;

use serde::Serialize;

use crate::numerics::distributions::student;
use crate::numerics::line::Line;
use crate::position::shorter_way_deg;

/// Probability that a steady diameter is called a trend, a test.
const FALSE_ALARM: f64 = 0.01;
/// Fewest readings of a window: with two degrees of freedom t is 9.9, with one 64.
const FEWEST: usize = 4;
/// Most readings of a window that are kept; of more every second one is left out.
const MOST: usize = 4096;
/// Share of the window that its readings must span: one reading at either end may be missing.
const SPANNED: f64 = 0.8;

/// Whether a diameter is good by now.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "state", rename_all = "snake_case")]
pub enum Settled {
    /// Its times are not stated (`t_ns`): whether readings lie seconds apart is not known.
    Untimed,
    /// Fewer seconds or readings than the window needs.
    Waiting {
        /// Seconds seen.
        seen_s: f64,
        /// Readings seen.
        readings: usize,
    },
    /// The diameter changes.
    Trend {
        /// Its change, µm/min; below 0 for a film that runs off or a part that cools.
        um_per_min: f64,
        /// Its standard error, µm/min.
        u_um_per_min: f64,
    },
    /// Readings over the window agree.
    Agrees {
        /// Standard uncertainty of the diameter by a trend too small to be seen, mm.
        u_trend_mm: f64,
    },
}

impl Settled {
    /// Standard uncertainty by what is left of a trend, mm; none where the diameter is not good.
    pub fn u_trend_mm(&self) -> Option<f64> {
        match self {
            Self::Agrees { u_trend_mm } => Some(*u_trend_mm),
            _ => None,
        }
    }

    /// Why the diameter is not good yet; `None` where it is.
    pub(crate) fn why(&self) -> Option<String> {
        Some(match *self {
            Self::Agrees { .. } => return None,
            Self::Untimed => "the frames have no times (t_ns in frames.csv)".to_owned(),
            Self::Waiting { seen_s, readings } => {
                format!("{readings} readings over {seen_s:.1} s are too few")
            }
            Self::Trend { um_per_min, u_um_per_min } => format!(
                "the diameter changes by {um_per_min:.2} um/min (u {u_um_per_min:.2} um/min): coolant that runs off, or a part \
                 that cools"
            ),
        })
    }
}

/// Readings of a part over time.
#[derive(Clone, Debug)]
pub struct Settling {
    window_s: f64,
    /// Seconds since the first reading, and mm.
    readings: VecDeque<(f64, f64)>,
    first_ns: Option<u64>,
}

impl Settling {
    /// A window of so many seconds, above 0.
    pub fn new(window_s: f64) -> Self {
        Self { window_s, readings: VecDeque::new(), first_ns: None }
    }

    /// Another part: nothing of the last one is known of it.
    pub fn restart(&mut self) {
        self.readings.clear();
        self.first_ns = None;
    }

    /// A reading of `d_mm` at `t_ns` on one clock; a time that runs back starts anew.
    pub fn push(&mut self, t_ns: u64, d_mm: f64) -> Settled {
        let first = *self.first_ns.get_or_insert(t_ns);
        let last = self.readings.back().map_or(0.0, |r| r.0);
        let t_s = 1e-9 * t_ns.saturating_sub(first) as f64;
        if t_ns < first || t_s < last {
            self.restart();
            return self.push(t_ns, d_mm);
        }
        self.readings.push_back((t_s, d_mm));
        while self.readings.front().is_some_and(|r| t_s - r.0 > self.window_s) {
            self.readings.pop_front();
        }
        if self.readings.len() > MOST {
            let mut keeps = false;
            self.readings.retain(|_| {
                keeps = !keeps;
                keeps
            });
        }
        self.state()
    }

    fn state(&self) -> Settled {
        let (n, ends) = (self.readings.len(), self.readings.front().zip(self.readings.back()));
        let seen_s = ends.map_or(0.0, |(first, last)| last.0 - first.0);
        if n > FEWEST && seen_s == 0.0 {
            return Settled::Untimed;
        }
        if n < FEWEST || seen_s < SPANNED * self.window_s {
            return Settled::Waiting { seen_s, readings: n };
        }
        let line = Line::through(self.readings.iter().copied());
        let freedom = (n - 2) as f64;
        let residual: f64 = self.readings.iter().map(|(t, d)| (d - line.at(*t)).powi(2)).sum();
        let u_slope = (residual / freedom / line.square).sqrt();
        let (slope, t) = (line.slope(), student(freedom, 1.0 - FALSE_ALARM));
        if slope.abs() > t * u_slope {
            let per_minute = 60.0 * 1e3;
            return Settled::Trend { um_per_min: per_minute * slope, u_um_per_min: per_minute * u_slope };
        }
        let largest = slope.abs() + t * u_slope;
        Settled::Agrees { u_trend_mm: 0.5 * largest * self.window_s / 3.0_f64.sqrt() }
    }
}

/// Angle by which a turning part may seem to turn back, degrees: an encoder at rest jitters by some
/// counts, and a thousand of them are a turn at least.
const JITTER_DEG: f64 = 1.0;
/// What rounding may leave of a whole turn of even steps, degrees.
const ROUNDING_DEG: f64 = 1e-6;

/// Means of whole turns of a part that turns, one a turn, whichever way it turns.
///
/// A mean is that over the angle (trapezoids between the readings), so that a spindle that slows
/// down does not weigh one side of the part more. Readings lie less than half a turn apart: a step
/// is the smaller of the two ways round. A spindle that turns back begins its turn anew.
#[derive(Clone, Debug, Default)]
pub struct TurnMeans {
    /// Angle of the last reading, degrees, and the reading, mm.
    last: Option<(f64, f64)>,
    /// Angle turned since the turn began, degrees; below 0 for falling angles.
    turned_deg: f64,
    /// Integral of the diameter over it, mm·degrees.
    sum_mm_deg: f64,
    from_ns: u64,
}

impl TurnMeans {
    /// A reading at a spindle angle, which rises or falls; the mean and the middle in time of the
    /// turn that it ends. The first turn begins with the first reading.
    pub fn push(&mut self, t_ns: u64, angle_deg: f64, d_mm: f64) -> Option<(u64, f64)> {
        let Some((last_deg, last_mm)) = self.last.replace((angle_deg, d_mm)) else {
            self.begin(t_ns);
            return None;
        };
        let step_deg = shorter_way_deg(last_deg, angle_deg);
        let turns_back = step_deg * self.turned_deg < 0.0 && step_deg.abs() > JITTER_DEG;
        if turns_back || !step_deg.is_finite() {
            self.begin(t_ns);
            return None;
        }
        let before_deg = self.turned_deg.abs();
        self.turned_deg += step_deg;
        let after_deg = self.turned_deg.abs();
        let mean = |share: f64| last_mm + 0.5 * share * (d_mm - last_mm);
        if after_deg < 360.0 - ROUNDING_DEG {
            // a step back within the jitter takes its part off again
            self.sum_mm_deg += (after_deg - before_deg) * mean(1.0);
            return None;
        }
        let left_deg = 360.0 - before_deg;
        let turn_mm = (self.sum_mm_deg + left_deg * mean(left_deg / step_deg.abs())) / 360.0;
        let middle_ns = self.from_ns + t_ns.saturating_sub(self.from_ns) / 2;
        self.begin(t_ns);
        Some((middle_ns, turn_mm))
    }

    /// A turn begins at the last reading.
    fn begin(&mut self, t_ns: u64) {
        (self.turned_deg, self.sum_mm_deg, self.from_ns) = (0.0, 0.0, t_ns);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Deviates that are reproducible and nearly normal: the sum of twelve uniform ones.
    struct Noise(u64);

    impl Noise {
        fn next(&mut self) -> f64 {
            (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
        }

        fn uniform(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    const SECOND: u64 = 1_000_000_000;

    #[test]
    fn a_film_that_runs_off_is_a_trend_until_it_has() {
        // 24 µm over 24 frames of half a second, then steady; .2 µm of noise
        let mut noise = Noise(7);
        let mut settling = Settling::new(5.0);
        let mut good_at = None;
        for i in 0..60_u64 {
            let film_mm = 1e-3 * (24.0 - i as f64).max(0.0);
            let state = settling.push(i * SECOND / 2, 20.0 + film_mm + 2e-4 * noise.next());
            match state {
                Settled::Agrees { u_trend_mm } => {
                    assert!(i > 24, "frame {i} of the film is good");
                    // the last micrometre of the film may still be in the window
                    assert!(u_trend_mm < 2e-3, "{u_trend_mm}");
                    good_at.get_or_insert(i);
                }
                Settled::Trend { um_per_min, u_um_per_min } if i == 20 => {
                    assert!((um_per_min + 120.0).abs() < 4.0 * u_um_per_min, "{um_per_min}");
                }
                Settled::Trend { um_per_min, .. } => assert!(um_per_min < 0.0 || i > 35, "{i} {um_per_min}"),
                Settled::Waiting { .. } => assert!(i < 8, "{i}"),
                Settled::Untimed => panic!("times are stated"),
            }
        }
        assert!(good_at.is_some_and(|i| i <= 36), "{good_at:?}");
    }

    #[test]
    fn false_alarms_come_as_often_as_stated() {
        // windows that share no reading: 4000 tests at 1 %, ± 4 standard deviations
        let mut noise = Noise(11);
        let alarms = (0..4000)
            .filter(|_| {
                let mut settling = Settling::new(9.0);
                let last = (0..10).map(|i| settling.push(i * SECOND, 1e-3 * noise.next())).last();
                matches!(last, Some(Settled::Trend { .. }))
            })
            .count() as f64;
        assert!((alarms - 40.0).abs() < 4.0 * 40.0_f64.sqrt(), "{alarms}");
    }

    /// The slope and its standard error are those of the textbook sums.
    #[test]
    fn the_line_is_that_of_the_sums() {
        let d = [1.0, 1.4, 2.1, 2.4, 3.1];
        let mut settling = Settling::new(4.0);
        let last = d.iter().zip(0..).map(|(d, i)| settling.push(i * SECOND, *d)).last();
        // Σ(t − 2)² = 10, Σ(t − 2)(d − d̄) = 5.2; residuals² = .036
        let Some(Settled::Trend { um_per_min, u_um_per_min }) = last else { panic!("{last:?}") };
        assert!((um_per_min / 6e4 - 0.52).abs() < 1e-12, "{um_per_min}");
        assert!((u_um_per_min / 6e4 - (0.036_f64 / 3.0 / 10.0).sqrt()).abs() < 1e-12, "{u_um_per_min}");
    }

    #[test]
    fn what_is_not_known_is_no_agreement() {
        let mut untimed = Settling::new(1.0);
        assert_eq!((0..9).map(|_| untimed.push(0, 1.0)).last(), Some(Settled::Untimed));
        let mut short = Settling::new(10.0);
        let state = (0..5).map(|i| short.push(i * SECOND, 1.0)).last();
        assert_eq!(state, Some(Settled::Waiting { seen_s: 4.0, readings: 5 }));
        // a clock that is set back starts anew
        assert_eq!(short.push(0, 1.0), Settled::Waiting { seen_s: 0.0, readings: 1 });
        // a pause longer than the window leaves one reading
        let mut pause = Settling::new(10.0);
        for i in 0..20 {
            pause.push(i * SECOND, 1.0);
        }
        assert_eq!(pause.push(100 * SECOND, 1.0), Settled::Waiting { seen_s: 0.0, readings: 1 });
        assert_eq!(pause.state().u_trend_mm(), None);
    }

    #[test]
    fn lobes_of_a_turning_part_are_no_trend_whichever_way_it_turns() {
        for sign in [1.0, -1.0] {
            let mut means = TurnMeans::default();
            let mut settling = Settling::new(4.0);
            let (mut last, mut turns) = (None, 0);
            for i in 0..120_u64 {
                let angle = sign * 30.0 * i as f64;
                let d_mm = 20.0 + 0.01 * (2.0 * angle).to_radians().cos() + 1e-5 * (i / 12 % 2) as f64;
                if let Some((t_ns, mean_mm)) = means.push(i * SECOND / 24, angle.rem_euclid(360.0), d_mm) {
                    (last, turns) = (Some(settling.push(t_ns, mean_mm)), turns + 1);
                    assert!((mean_mm - 20.0).abs() < 2e-5, "{sign} {mean_mm}");
                }
            }
            // 119 steps of 30°: nine whole turns, the tenth lacks a step
            assert!(turns == 9 && matches!(last, Some(Settled::Agrees { .. })), "{sign} {turns} {last:?}");
        }
    }

    #[test]
    fn a_mean_is_that_over_the_angle_and_a_turn_back_is_none() {
        // readings at uneven steps that fall through 0: trapezoids of an even function
        let mut means = TurnMeans::default();
        let steps = [10.0, 35.0, 20.0, 40.0, 15.0];
        let (mut angle, mut found) = (200.0_f64, Vec::new());
        for i in 0..60_u64 {
            let d_mm = 20.0 + 0.001 * angle.to_radians().cos();
            found.extend(means.push(i, angle.rem_euclid(360.0), d_mm).map(|turn| turn.1));
            angle -= steps[i as usize % 5];
        }
        assert_eq!(found.len(), 3, "{found:?}");
        assert!(found.iter().all(|mm| (mm - 20.0).abs() < 5e-5), "{found:?}");
        // 300° on, 200° back, and on again: no turn before 360° in one sense
        let mut back = TurnMeans::default();
        let mut turns = 0;
        let ways =
            (0..=10).map(|i| 30 * i).chain((3..10).rev().map(|i| 30 * i)).chain((4..15).map(|i| 30 * i));
        for (i, angle) in ways.enumerate() {
            turns += u32::from(back.push(i as u64, f64::from(angle), 20.0).is_some());
        }
        assert_eq!(turns, 0);
        // at rest, with the jitter of a count, there is no turn
        let mut rest = TurnMeans::default();
        assert!((0..1000).all(|i| rest.push(i, 0.1 * (i % 2) as f64, 20.0).is_none()));
    }
}
