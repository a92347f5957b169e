//! Averaging of successive readings and statistics of a series.
//!
//! Gaps pass through and leave the averages untouched: a refused reading must not bias a mean. The
//! random uncertainty shrinks by the weights of the average, and is never less than the scatter of
//! the readings averaged implies (see `reading_scatter`); the common one does not shrink.

use std::collections::VecDeque;

use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};
use thiserror::Error;

use super::reading_scatter::{SeriesLimits, SeriesMean};
use crate::gauge::width::reused::Reused;
use crate::numerics::robust::central_median;
use crate::profile::{Diameter, Reading};

/// Why an average or an index cannot be formed.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum StatisticsError {
    /// An argument out of range.
    #[error("{name} = {value}: must be {right}")]
    Argument {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What would be right.
        right: &'static str,
    },
    /// Not enough readings, or none that differ.
    #[error("{found} readings with a standard deviation of {sd}: at least 2 that differ are needed")]
    TooFew {
        /// Readings so far.
        found: u64,
        /// Their standard deviation.
        sd: f64,
    },
    /// The readings scatter no more than their own noise.
    #[error(
        "the standard deviation {sd:.3e} is not above what the readings' own random uncertainty, {noise:.3e}, explains"
    )]
    OnlyNoise {
        /// Standard deviation of the readings.
        sd: f64,
        /// Root mean square of their random standard uncertainties.
        noise: f64,
    },
}

/// How successive readings are averaged.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Averaging {
    /// Every reading by itself.
    #[default]
    Off,
    /// Mean of the last n readings, of fewer while there are not yet n.
    Moving {
        /// Readings averaged. At least 1.
        readings: usize,
    },
    /// Median of the last n readings: one wild reading in three does no harm; u is 1.00-1.25 times
    /// that of the mean.
    Median {
        /// Readings looked at. At least 1.
        readings: usize,
    },
    /// y + weight·(x − y): settles with weight/(2 − weight) of the variance.
    Recursive {
        /// Weight of the newest reading. Above 0, at most 1.
        weight: f64,
    },
}

/// An average in progress.
#[derive(Clone, Debug)]
pub(crate) struct Average {
    averaging: Averaging,
    window: VecDeque<Diameter>,
    state: Option<Recursion>,
}

impl Average {
    /// A fresh average.
    ///
    /// # Errors
    /// Refuses windows of no reading and weights outside 0..=1.
    pub(crate) fn new(averaging: Averaging) -> Result<Self, StatisticsError> {
        match averaging {
            Averaging::Moving { readings: 0 } | Averaging::Median { readings: 0 } => {
                Err(StatisticsError::Argument { name: "readings", value: 0.0, right: "at least 1" })
            }
            Averaging::Recursive { weight } if !(weight > 0.0 && weight <= 1.0) => {
                Err(StatisticsError::Argument { name: "weight", value: weight, right: "above 0, at most 1" })
            }
            _ => Ok(Self { averaging, window: VecDeque::new(), state: None }),
        }
    }

    /// Takes a reading, gives the average; a gap gives itself and changes nothing.
    pub(crate) fn push(&mut self, reading: Reading) -> Reading {
        let Reading::Value(newest) = reading else { return reading };
        Reading::Value(match self.averaging {
            Averaging::Off => newest,
            Averaging::Moving { readings } => {
                self.remember(newest, readings);
                mean(self.window.make_contiguous(), newest)
            }
            Averaging::Median { readings } => {
                self.remember(newest, readings);
                median(self.window.make_contiguous(), newest)
            }
            Averaging::Recursive { weight } => {
                let next = self.state.map_or(Recursion::start(newest), |old| old.next(newest, weight));
                self.state = Some(next);
                next.average()
            }
        })
    }

    fn remember(&mut self, newest: Diameter, readings: usize) {
        if self.window.len() == readings {
            self.window.pop_front();
        }
        self.window.push_back(newest);
    }
}

fn mean(window: &[Diameter], newest: Diameter) -> Diameter {
    SeriesMean::of(window).map_or(newest, |series| series.mean)
}

fn median(window: &[Diameter], newest: Diameter) -> Diameter {
    let mut values: Reused<f64> = window.iter().map(|d| d.d_mm).collect();
    let d_mm = central_median(&mut values).unwrap_or(newest.d_mm);
    let mean = mean(window, newest);
    let u_random_mm = mean.u_random_mm * median_penalty(values.len());
    Diameter { d_mm, u_random_mm, ..mean }
}

/// A recursive average with the scatter of its readings, both with the same weights.
#[derive(Clone, Copy, Debug)]
struct Recursion {
    /// The average with what the readings state.
    stated: Diameter,
    /// Σ of the readings' squared weights: 1/n of a mean of n readings, weight/(2 − weight) in the
    /// end.
    squared_weights: f64,
    /// Weighted mean of the squared departures, mm², biased by the factor 1 − Σ w² (West, Comm. ACM
    /// 22 (1979) 532).
    square: f64,
    /// The same of products of neighbours.
    product: f64,
    /// Departure of the newest reading from the average before it, mm.
    departure: f64,
    weight: f64,
}

impl Recursion {
    fn start(first: Diameter) -> Self {
        Self { stated: first, squared_weights: 1.0, square: 0.0, product: 0.0, departure: 0.0, weight: 1.0 }
    }

    fn next(self, newest: Diameter, weight: f64) -> Self {
        let (old, kept) = (self.stated, 1.0 - weight);
        let departure = newest.d_mm - old.d_mm;
        Self {
            stated: Diameter {
                d_mm: old.d_mm + weight * departure,
                u_random_mm: (kept * old.u_random_mm).hypot(weight * newest.u_random_mm),
                u_common_mm: old.u_common_mm + weight * (newest.u_common_mm - old.u_common_mm),
            },
            squared_weights: kept * kept * self.squared_weights + weight * weight,
            square: kept * (self.square + weight * departure * departure),
            product: kept * (self.product + weight * departure * self.departure),
            departure,
            weight,
        }
    }

    /// The average with the larger random uncertainty of stated and scattered. With an
    /// autocorrelation φ^k that independent readings do not show by chance (1.96 standard
    /// deviations) the average's variance is (1 + kept·φ)/(1 − kept·φ) times that of independent
    /// ones.
    fn average(&self) -> Diameter {
        let freedom = 1.0 - self.squared_weights;
        if !(freedom > 0.0 && self.square > 0.0) {
            return self.stated;
        }
        let phi = (self.product / self.square).clamp(0.0, 0.99);
        let kept = if phi > SeriesLimits::get().beyond_chance * self.squared_weights.sqrt() {
            (1.0 - self.weight) * phi
        } else {
            0.0
        };
        let variance = self.square / freedom * self.squared_weights * (1.0 + kept) / (1.0 - kept);
        Diameter { u_random_mm: self.stated.u_random_mm.max(variance.sqrt()), ..self.stated }
    }
}

/// Standard deviation of the median of n normal readings over that of their mean: 1, 1, 1.160,
/// 1.092, 1.198, …, √(π/2).
///
/// n ≤ 7 tabulated (David & Nagaraja, Order Statistics); above, var ≈ π/2/(n + π/2 − 1) for odd n,
/// within 1 %; an even n is taken as the odd one below it, at its own n, which overstates by 5 % at
/// most.
fn median_penalty(n: usize) -> f64 {
    const SMALL: [f64; 8] = [1.0, 1.0, 1.0, 1.160_2, 1.092_2, 1.197_6, 1.135_1, 1.213_7];
    if let Some(small) = SMALL.get(n) {
        return *small;
    }
    let odd = (n - 1 + n % 2) as f64;
    let half_pi = std::f64::consts::FRAC_PI_2;
    (half_pi * odd / (odd + half_pi - 1.0)).sqrt()
}

/// Mean, scatter and extremes of a series, updated one by one (Welford), of any unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub(crate) struct RunningStatistics {
    count: u64,
    mean: f64,
    squares: f64,
    min: f64,
    max: f64,
}

/// A capability index with a two-sided confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Capability {
    /// The index.
    pub index: f64,
    /// Lower end of the interval.
    pub lower: f64,
    /// Upper end of the interval.
    pub upper: f64,
}

impl RunningStatistics {
    /// Takes a value; non-finite ones are left out.
    pub(crate) fn push(&mut self, value: f64) {
        if !value.is_finite() {
            return;
        }
        (self.min, self.max) =
            if self.count == 0 { (value, value) } else { (self.min.min(value), self.max.max(value)) };
        self.count += 1;
        let before = value - self.mean;
        self.mean += before / self.count as f64;
        self.squares += before * (value - self.mean);
    }

    /// Values so far.
    pub(crate) fn count(&self) -> u64 {
        self.count
    }

    /// Mean; 0 without values.
    pub(crate) fn mean(&self) -> f64 {
        self.mean
    }

    /// Least and greatest value; `None` without values.
    pub(crate) fn extremes(&self) -> Option<(f64, f64)> {
        (self.count > 0).then_some((self.min, self.max))
    }

    /// Experimental standard deviation (n − 1; GUM 4.2.2); 0 below two values.
    pub(crate) fn sd(&self) -> f64 {
        if self.count < 2 { 0.0 } else { (self.squares / (self.count - 1) as f64).sqrt() }
    }

    /// Standard uncertainty of the mean, type A (GUM 4.2.3).
    #[cfg(test)]
    pub(crate) fn u_mean(&self) -> f64 {
        self.sd() / (self.count.max(1) as f64).sqrt()
    }

    /// Cp = (upper − lower)/6s with its interval from χ² (ISO 22514-2, normal and stable process:
    /// otherwise it is Pp).
    ///
    /// # Errors
    /// Fewer than two different values; limits out of order; a confidence outside 0..1.
    pub(crate) fn cp(&self, lower: f64, upper: f64, confidence: f64) -> Result<Capability, StatisticsError> {
        self.check(lower, upper, confidence)?;
        let freedom = (self.count - 1) as f64;
        let chi2 = ChiSquared::new(freedom)
            .map_err(|_| StatisticsError::TooFew { found: self.count, sd: self.sd() })?;
        let index = (upper - lower) / (6.0 * self.sd());
        let end = |p: f64| index * (chi2.inverse_cdf(p) / freedom).sqrt();
        Ok(Capability { index, lower: end(0.5 - 0.5 * confidence), upper: end(0.5 + 0.5 * confidence) })
    }

    /// Cpk = min(upper − mean, mean − lower)/3s with Bissell's interval, Cpk·[1 ± z·√(1/(9n·Cpk²) +
    /// 1/2(n−1))].
    ///
    /// # Errors
    /// As [`Self::cp`].
    pub(crate) fn cpk(&self, lower: f64, upper: f64, confidence: f64) -> Result<Capability, StatisticsError> {
        self.check(lower, upper, confidence)?;
        let n = self.count as f64;
        let index = (upper - self.mean).min(self.mean - lower) / (3.0 * self.sd());
        let z = Normal::standard().inverse_cdf(0.5 + 0.5 * confidence);
        let half = z * (1.0 / (9.0 * n) + index * index / (2.0 * (n - 1.0))).sqrt();
        Ok(Capability { index, lower: index - half, upper: index + half })
    }

    /// Whether the scatter is more than that of noise of a variance, at a risk of an error of the
    /// first kind (one-sided χ² test).
    ///
    /// # Errors
    /// Fewer than two values; scatter that noise explains.
    pub(crate) fn exceeds_noise(&self, variance: f64, risk: f64) -> Result<(), StatisticsError> {
        let too_few = || StatisticsError::TooFew { found: self.count, sd: self.sd() };
        let freedom = self.count.checked_sub(1).filter(|n| *n > 0).ok_or_else(too_few)? as f64;
        let quantile = ChiSquared::new(freedom).map_err(|_| too_few())?.inverse_cdf(1.0 - risk) / freedom;
        if self.sd().powi(2) > quantile * variance {
            return Ok(());
        }
        Err(StatisticsError::OnlyNoise { sd: self.sd(), noise: variance.sqrt() })
    }

    fn check(&self, lower: f64, upper: f64, confidence: f64) -> Result<(), StatisticsError> {
        if self.sd().is_nan() || self.sd() <= 0.0 {
            return Err(StatisticsError::TooFew { found: self.count, sd: self.sd() });
        }
        let width = upper - lower;
        if width.is_nan() || width <= 0.0 {
            let right = "above 0";
            return Err(StatisticsError::Argument { name: "upper - lower limit", value: width, right });
        }
        if !(confidence > 0.0 && confidence < 1.0) {
            let right = "between 0 and 1";
            return Err(StatisticsError::Argument { name: "confidence", value: confidence, right });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;
    use crate::profile::Reason;

    fn reading(d_mm: f64) -> Reading {
        Reading::Value(Diameter { d_mm, u_random_mm: 1.0, u_common_mm: 0.5 })
    }

    #[test]
    fn averages_follow_their_definitions_and_leave_gaps_out() {
        let series = [1.0, 2.0, 9.0, 4.0];
        let last = |averaging: Averaging| {
            let mut average = Average::new(averaging).unwrap();
            let mut out = Reading::Gap(Reason::NoEdge);
            for (i, d) in series.iter().enumerate() {
                if i == 2 {
                    assert_eq!(
                        average.push(Reading::Gap(Reason::Contaminated)),
                        Reading::Gap(Reason::Contaminated)
                    );
                }
                out = average.push(reading(*d));
            }
            out.value().unwrap()
        };
        assert_eq!(last(Averaging::Off).d_mm, 4.0);
        assert_eq!(last(Averaging::Moving { readings: 3 }).d_mm, 5.0);
        // 2, 9, 4 scatter by 3.6 and state 1.
        assert!(
            (last(Averaging::Moving { readings: 3 }).u_random_mm - 13f64.sqrt() / 3f64.sqrt()).abs() < 1e-12
        );
        assert_eq!(last(Averaging::Median { readings: 3 }).d_mm, 4.0);
        assert_eq!(last(Averaging::Recursive { weight: 0.5 }).d_mm, 4.625);
        assert_eq!(last(Averaging::Moving { readings: 3 }).u_common_mm, 0.5);
        assert!(Average::new(Averaging::Recursive { weight: 0.0 }).is_err());
        assert!(Average::new(Averaging::Median { readings: 0 }).is_err());
    }

    #[test]
    fn an_average_is_never_surer_than_its_readings_scatter() {
        let mut random = rand_pcg::Pcg64::seed_from_u64(5);
        let normal = rand_distr::Normal::new(0.0, 1.0).unwrap();
        let cases = [
            Averaging::Moving { readings: 7 },
            Averaging::Recursive { weight: 0.2 },
            Averaging::Median { readings: 3 },
            Averaging::Median { readings: 6 },
            Averaging::Median { readings: 7 },
            Averaging::Median { readings: 9 },
        ];
        for averaging in cases {
            // Readings that scatter as their u implies, and three times as much.
            for scale in [1.0, 3.0] {
                let (mut square, mut u_square, mut least, runs) = (0.0, 0.0, f64::INFINITY, 20_000);
                for _ in 0..runs {
                    let mut average = Average::new(averaging).unwrap();
                    let mut out = None;
                    for _ in 0..30 {
                        out = average.push(reading(scale * random.sample(normal))).value();
                    }
                    square += out.unwrap().d_mm.powi(2) / f64::from(runs);
                    u_square += out.unwrap().u_random_mm.powi(2) / f64::from(runs);
                    least = least.min(out.unwrap().u_random_mm);
                }
                let ratio = (square / u_square).sqrt();
                // The larger one of two estimates is too large by up to 1.17 of three readings, by
                // less of more.
                let range = if scale > 1.0 { 0.92..1.03 } else { 0.84..1.025 };
                assert!(range.contains(&ratio), "{averaging:?} {scale}: {ratio}");
                if scale == 1.0 {
                    assert!(
                        (least / square.sqrt() - 1.0).abs() < 0.025,
                        "{averaging:?}: {least} {}",
                        square.sqrt()
                    );
                }
            }
        }
    }

    /// Readings of autocorrelation 0.8^k: the average's own scatter must not exceed what it states.
    #[test]
    fn a_recursive_average_of_a_slow_wander_says_so() {
        let mut random = rand_pcg::Pcg64::seed_from_u64(7);
        let normal = rand_distr::Normal::new(0.0, 1.0).unwrap();
        let (mut square, mut u_square, runs) = (0.0, 0.0, 4000);
        for _ in 0..runs {
            let mut average = Average::new(Averaging::Recursive { weight: 0.05 }).unwrap();
            let (mut x, mut out): (f64, _) = (random.sample(normal), None);
            for _ in 0..200 {
                out = average.push(reading(10.0 * x)).value();
                x = 0.8 * x + 0.6 * random.sample(normal);
            }
            square += out.unwrap().d_mm.powi(2);
            u_square += out.unwrap().u_random_mm.powi(2);
        }
        let ratio: f64 = (square / u_square).sqrt();
        assert!((0.8..1.25).contains(&ratio), "{ratio}");
    }

    #[test]
    fn running_statistics_are_those_of_the_whole_series_even_far_from_zero() {
        let mut s = RunningStatistics::default();
        for v in [1e9 + 4.0, 1e9 + 7.0, 1e9 + 13.0, 1e9 + 16.0, f64::NAN] {
            s.push(v);
        }
        assert_eq!((s.count(), s.mean() - 1e9, s.extremes()), (4, 10.0, Some((1e9 + 4.0, 1e9 + 16.0))));
        assert!((s.sd() - 30f64.sqrt()).abs() < 1e-9 && (s.u_mean() - 7.5f64.sqrt()).abs() < 1e-9);
        // Four values of 30 against their noise: χ²(0.95; 3)/3 = 2.605.
        assert!(s.exceeds_noise(30.0 / 2.606, 0.05).is_ok() && s.exceeds_noise(30.0 / 2.604, 0.05).is_err());
        assert!(s.cp(0.0, -1.0, 0.95).is_err() && RunningStatistics::default().cpk(0.0, 1.0, 0.95).is_err());
    }

    #[test]
    fn capability_intervals_cover_as_often_as_they_say() {
        let mut random = rand_pcg::Pcg64::seed_from_u64(6);
        let normal = rand_distr::Normal::new(0.5, 1.0).unwrap();
        let (mut cp_hits, mut cpk_hits, runs) = (0, 0, 4000);
        for _ in 0..runs {
            let mut s = RunningStatistics::default();
            for _ in 0..50 {
                s.push(random.sample(normal));
            }
            let inside = |c: Capability, truth: f64| u32::from((c.lower..c.upper).contains(&truth));
            cp_hits += inside(s.cp(-4.0, 4.0, 0.95).unwrap(), 8.0 / 6.0);
            cpk_hits += inside(s.cpk(-4.0, 4.0, 0.95).unwrap(), 3.5 / 3.0);
        }
        for hits in [cp_hits, cpk_hits] {
            let coverage = f64::from(hits) / f64::from(runs);
            assert!((coverage - 0.95).abs() < 0.015, "{coverage}");
        }
    }
}
