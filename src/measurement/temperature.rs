//! Temperatures that age, and the drift of a gauge since it was set to zero.
//!
//! A thermometer's last value holds for `max_age_s` with its own limits. After that they grow by
//! `growth_k_per_s`, because the part goes on cooling unseen, and beyond `refused_age_s` there is
//! no value. A gauge drifts with time and with the temperature of its head from its zero on: a row
//! of the budget that grows until the interval of re-zeroing is over; then nothing is good.

use crate::setting::{SettingError, require};

/// How long temperatures hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TemperatureAge {
    /// Age up to which a value holds with the limits of its thermometer, s.
    pub max_age_s: f64,
    /// Growth of its limits beyond that age, K/s.
    pub growth_k_per_s: f64,
    /// Age beyond which there is none, s.
    pub refused_age_s: f64,
}

impl Default for TemperatureAge {
    /// A steel part of 25 mm in still air (20 W/(m²·K)) has a time constant of d·ρ·c/(4h) = 1100 s:
    /// 20 K above the air it cools by 0.018 K/s. In ten seconds that is a fifth of a kelvin, the
    /// limit of a good contact thermometer; in ten minutes 8 K, more than a temperature is worth.
    fn default() -> Self {
        Self { max_age_s: 10.0, growth_k_per_s: 0.02, refused_age_s: 600.0 }
    }
}

/// A value of the part's thermometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TemperatureSample {
    /// When, ns, on the clock of the frames.
    pub t_ns: u64,
    /// Temperature of the part, °C.
    pub part_c: f64,
    /// Limits of its error, ± K.
    pub limit_k: f64,
    /// Temperature of the head, °C, where it is known.
    pub head_c: Option<f64>,
    /// Temperature of what the scale rests on (lens and its mount), °C, where it is measured apart.
    pub scale_c: Option<f64>,
}

/// Most samples that are kept, 48 MB of them: twelve days of one a second. Of more the older half
/// is let go.
const MOST: usize = 1 << 20;

/// Temperatures over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Temperatures {
    samples: Vec<TemperatureSample>,
    age: TemperatureAge,
}

impl Temperatures {
    /// Samples whose times rise.
    ///
    /// # Errors
    /// No sample, times that do not rise, values out of range: the message numbers the sample from
    /// 1.
    pub fn new(samples: Vec<TemperatureSample>, age: TemperatureAge) -> Result<Self, String> {
        if samples.is_empty() {
            return Err("holds no temperature".to_owned());
        }
        let mut read = Self::awaited(age);
        for (sample, number) in samples.into_iter().zip(1..) {
            read.push(sample).map_err(|why| format!("sample {number}: {why}"))?;
        }
        Ok(read)
    }

    /// No sample yet: they come by [`Self::push`].
    pub fn awaited(age: TemperatureAge) -> Self {
        Self { samples: Vec::new(), age }
    }

    /// One more sample.
    ///
    /// # Errors
    /// A time that does not rise, values out of range: the sample is then left out.
    pub fn push(&mut self, sample: TemperatureSample) -> Result<(), String> {
        let TemperatureSample { t_ns, part_c, limit_k, head_c, scale_c } = sample;
        if self.samples.last().is_some_and(|last| last.t_ns >= t_ns) {
            return Err(format!("t_ns {t_ns} does not rise"));
        }
        let in_range = |c: f64| (-50.0..=400.0).contains(&c);
        if !in_range(part_c) {
            return Err(format!("part_c {part_c} must lie in -50 to 400 °C"));
        }
        for (name, beside_c) in [("head_c", head_c), ("scale_c", scale_c)] {
            if let Some(c) = beside_c.filter(|c| !in_range(*c)) {
                return Err(format!("{name} {c} must lie in -50 to 400 °C"));
            }
        }
        if !(0.0..=100.0).contains(&limit_k) {
            return Err(format!("limit_k {limit_k} must lie in 0 to 100 K"));
        }
        if self.samples.len() == MOST {
            self.samples.drain(..MOST / 2);
        }
        self.samples.push(sample);
        Ok(())
    }

    /// Time of the last sample, ns.
    pub fn last_ns(&self) -> Option<u64> {
        self.samples.last().map(|last| last.t_ns)
    }

    /// The last sample at `t_ns` or before.
    ///
    /// # Errors
    /// No sample before, or one that is too old.
    fn sample(&self, t_ns: u64) -> Result<(&TemperatureSample, f64), String> {
        let before = self.samples.partition_point(|s| s.t_ns <= t_ns);
        let Some(last) = before.checked_sub(1).and_then(|i| self.samples.get(i)) else {
            return Err(match self.samples.first() {
                None => "no temperature of the part yet".to_owned(),
                Some(first) => {
                    format!("no temperature of the part before t_ns {t_ns}; the first is of {}", first.t_ns)
                }
            });
        };
        let age_s = 1e-9 * (t_ns - last.t_ns) as f64;
        if age_s > self.age.refused_age_s {
            return Err(format!(
                "the temperature of the part is {age_s:.0} s old, {:.0} s at most: is the thermometer connected?",
                self.age.refused_age_s
            ));
        }
        Ok((last, age_s))
    }

    /// Temperature of the part at `t_ns`, °C, and the limits of its error by age, ± K.
    ///
    /// # Errors
    /// No sample before, or one that is too old.
    pub fn at(&self, t_ns: u64) -> Result<(f64, f64), String> {
        let (last, age_s) = self.sample(t_ns)?;
        Ok((last.part_c, last.limit_k + self.stale_k(age_s)))
    }

    /// What a temperature may have changed by beyond the age up to which it holds, K.
    fn stale_k(&self, age_s: f64) -> f64 {
        self.age.growth_k_per_s * (age_s - self.age.max_age_s).max(0.0)
    }

    /// Temperature of the scale at `t_ns`, °C, that of the head where it has none of its own, and
    /// what it may have changed by since, K; `None` where the last sample has neither.
    ///
    /// # Errors
    /// As [`Self::at`].
    pub fn scale_at(&self, t_ns: u64) -> Result<Option<(f64, f64)>, String> {
        let (last, age_s) = self.sample(t_ns)?;
        Ok(last.scale_c.or(last.head_c).map(|c| (c, self.stale_k(age_s))))
    }

    /// Temperature of the head at `t_ns`, °C; `None` where the last sample has none.
    ///
    /// # Errors
    /// As [`Self::at`].
    pub fn head_at(&self, t_ns: u64) -> Result<Option<f64>, String> {
        self.sample(t_ns).map(|(last, _)| last.head_c)
    }
}

/// Drift of the scale with its temperature since it was calibrated, as limits of its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScaleDrift {
    /// Limits of the drift, ± ppm/K: of a lens in aluminium 23.
    pub ppm_per_k: f64,
    /// Temperature of the scale when it was calibrated, °C.
    pub calibrated_c: f64,
}

impl ScaleDrift {
    /// Limits of the scale's error at a temperature, °C, that may have changed by `stale_k` since
    /// it was read, ± ppm.
    pub fn limit_ppm(&self, scale_c: f64, stale_k: f64) -> f64 {
        self.ppm_per_k * ((scale_c - self.calibrated_c).abs() + stale_k)
    }
}

/// Drift of a gauge since its last zero, as limits of a diameter's error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZeroDrift {
    /// Growth with time, µm/h.
    pub um_per_h: f64,
    /// Growth with the temperature of the head, µm/K.
    pub um_per_k: f64,
    /// Interval after which the gauge must be set to zero again, s.
    pub interval_s: f64,
}

impl ZeroDrift {
    /// Checks the values.
    ///
    /// # Errors
    /// [`SettingError`] names the key.
    pub fn validate(&self) -> Result<(), SettingError> {
        let at_least_0 = [("zero_drift.um_per_h", self.um_per_h), ("zero_drift.um_per_k", self.um_per_k)];
        for (key, value) in at_least_0 {
            require((0.0..=1e4).contains(&value), key, value, "0 to 10000")?;
        }
        let interval = self.interval_s;
        require(interval > 0.0 && interval.is_finite(), "zero_drift.interval_s", interval, "a time above 0 s")
    }

    /// Standard uncertainty of a diameter `since_s` after the zero, with the head's temperature
    /// changed by `head_k` since then, mm: both limits are of uniform distributions (GUM 4.3.7).
    ///
    /// # Errors
    /// An interval that is over.
    pub fn u_mm(&self, since_s: f64, head_k: f64) -> Result<f64, String> {
        if !(0.0..=self.interval_s).contains(&since_s) {
            return Err(format!(
                "the gauge was set to zero {since_s:.0} s ago, {:.0} s at most: measure the zero master again",
                self.interval_s
            ));
        }
        let (time_um, head_um) = (self.um_per_h * since_s / 3600.0, self.um_per_k * head_k);
        Ok(1e-3 * time_um.hypot(head_um) / 3.0_f64.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: u64 = 1_000_000_000;

    fn sample(t_s: u64, part_c: f64) -> TemperatureSample {
        TemperatureSample { t_ns: t_s * SECOND, part_c, limit_k: 0.2, head_c: None, scale_c: None }
    }

    #[test]
    fn a_temperature_grows_stale_and_is_refused() {
        let of = |samples| Temperatures::new(samples, TemperatureAge::default());
        let temperatures = of(vec![sample(100, 31.0), sample(130, 30.0)]).unwrap();
        assert!(temperatures.at(99 * SECOND).unwrap_err().contains("before"));
        assert_eq!(temperatures.at(110 * SECOND).unwrap(), (31.0, 0.2));
        let (part_c, limit_k) = temperatures.at(190 * SECOND).unwrap();
        assert!(part_c == 30.0 && (limit_k - (0.2 + 50.0 * 0.02)).abs() < 1e-12, "{limit_k}");
        assert!(temperatures.at(731 * SECOND).unwrap_err().contains("601 s old"));
        for (samples, word) in [
            (vec![], "no temperature"),
            (vec![sample(1, 20.0), sample(1, 20.0)], "sample 2: t_ns"),
            (vec![sample(1, 900.0)], "part_c"),
            (vec![TemperatureSample { limit_k: f64::NAN, ..sample(1, 20.0) }], "limit_k"),
        ] {
            assert!(of(samples).unwrap_err().contains(word), "{word}");
        }
    }

    #[test]
    fn samples_that_come_are_taken_where_their_times_rise() {
        let mut awaited = Temperatures::awaited(TemperatureAge::default());
        assert!(awaited.at(SECOND).unwrap_err().contains("yet") && awaited.last_ns().is_none());
        awaited.push(TemperatureSample { head_c: Some(25.0), ..sample(10, 30.0) }).unwrap();
        assert!(awaited.push(sample(10, 31.0)).unwrap_err().contains("does not rise"));
        let hot = TemperatureSample { head_c: Some(900.0), ..sample(11, 30.0) };
        assert!(awaited.push(hot).unwrap_err().contains("head_c"));
        assert_eq!(awaited.head_at(11 * SECOND), Ok(Some(25.0)));
        awaited.push(sample(12, 31.0)).unwrap();
        assert_eq!(awaited.at(12 * SECOND), Ok((31.0, 0.2)));
        assert_eq!((awaited.head_at(12 * SECOND), awaited.last_ns()), (Ok(None), Some(12 * SECOND)));
        // the scale's own temperature, else the head's; 50 s beyond the 10 s that it holds for are
        // 1 K
        assert_eq!(awaited.scale_at(11 * SECOND), Ok(Some((25.0, 0.0))));
        assert_eq!(awaited.scale_at(12 * SECOND), Ok(None));
        let both = TemperatureSample { head_c: Some(25.0), scale_c: Some(23.0), ..sample(20, 30.0) };
        awaited.push(both).unwrap();
        let (scale_c, stale_k) = awaited.scale_at(80 * SECOND).unwrap().unwrap();
        assert!(scale_c == 23.0 && (stale_k - 1.0).abs() < 1e-12, "{stale_k}");
        let drift = ScaleDrift { ppm_per_k: 23.0, calibrated_c: 21.0 };
        assert!((drift.limit_ppm(scale_c, stale_k) - 69.0).abs() < 1e-9);
        let hot = TemperatureSample { scale_c: Some(900.0), ..sample(90, 30.0) };
        assert!(awaited.push(hot).unwrap_err().contains("scale_c"));
    }

    #[test]
    fn drift_grows_from_the_zero_until_its_interval_is_over() {
        let drift = ZeroDrift { um_per_h: 1.2, um_per_k: 0.5, interval_s: 7200.0 };
        drift.validate().unwrap();
        assert_eq!(drift.u_mm(0.0, 0.0), Ok(0.0));
        // 1.2 µm after an hour and .5 µm by one kelvin: 1.3 µm/√3
        let u = drift.u_mm(3600.0, -1.0).unwrap();
        assert!((u - 1.3e-3 / 3.0_f64.sqrt()).abs() < 1e-12, "{u}");
        assert!(drift.u_mm(7201.0, 0.0).unwrap_err().contains("again"));
        assert!(ZeroDrift { interval_s: 0.0, ..drift }.validate().is_err());
    }
}
