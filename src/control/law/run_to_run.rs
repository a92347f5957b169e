//! Run-to-run control: the disturbance is estimated by moving averages and compensated.
//!
//! ```text
//! observed     m(k) = e(k) + b̂ o(k)                        the error without any offset
//! EWMA         a(k) = λ m(k) + (1 − λ) a(k−1)                          o(k+1) = a(k)/b̂
//! double EWMA  a(k) = λ₁ m(k) + (1 − λ₁) a(k−1)
//!              p(k) = λ₂ [m(k) − a(k−1)] + (1 − λ₂) p(k−1)             o(k+1) = [a(k) + p(k)]/b̂
//! ```
//!
//! E. Sachs, A. Hu, A. Ingolfsson, IEEE Trans. Semicond. Manuf. 8 (1995) 26; S. Butler, J. Stefani,
//! ibid. 7 (1994) 193 (the predictor-corrector form, as in A. Chen, R.-S. Guo, ibid. 14 (2001) 11).
//! Stable for 0 < λ b/b̂ < 2 with a constant disturbance, for the double form see `stability`.

use super::proposal::{Law, Observation, Proposal};
use crate::control::settings::{DoubleEwmaSettings, EwmaSettings};

/// EWMA per station.
#[derive(Clone, Debug)]
pub(crate) struct EwmaLaw {
    settings: EwmaSettings,
    passes: u32,
    level: Vec<f64>,
}

impl EwmaLaw {
    pub(crate) fn new(settings: &EwmaSettings, stations: usize) -> Self {
        Self { settings: settings.clone(), passes: 0, level: vec![0.0; stations] }
    }
}

/// m(k) per station.
fn disturbance<'a>(seen: &'a Observation<'_>, gain: f64) -> impl Iterator<Item = f64> + 'a {
    seen.errors.stations.iter().zip(seen.in_force()).map(move |(s, o)| s.e_mm + gain * o)
}

impl Law for EwmaLaw {
    fn begin(&mut self, _stock_mm: Option<Vec<f64>>) {
        *self = Self::new(&self.settings, self.level.len());
    }

    fn propose(&mut self, seen: &Observation<'_>) -> Proposal {
        self.passes += 1;
        let mean = if self.settings.mean_start { 1.0 / f64::from(self.passes) } else { 0.0 };
        let weight = self.settings.weight.max(mean);
        let gain = self.settings.gain_estimate;
        for (level, m) in self.level.iter_mut().zip(disturbance(seen, gain)) {
            *level += weight * (m - *level);
        }
        self.level.iter().map(|a| a / gain).collect::<Vec<_>>().into()
    }
}

/// a and p of a station.
#[derive(Clone, Copy, Debug, Default)]
struct LevelTrend {
    level: f64,
    trend: f64,
}

/// Double EWMA per station.
#[derive(Clone, Debug)]
pub(crate) struct DoubleEwmaLaw {
    settings: DoubleEwmaSettings,
    started: bool,
    stations: Vec<LevelTrend>,
}

impl DoubleEwmaLaw {
    pub(crate) fn new(settings: &DoubleEwmaSettings, stations: usize) -> Self {
        let stations = vec![LevelTrend::default(); stations];
        Self { settings: settings.clone(), started: false, stations }
    }
}

impl Law for DoubleEwmaLaw {
    fn begin(&mut self, _stock_mm: Option<Vec<f64>>) {
        *self = Self::new(&self.settings, self.stations.len());
    }

    fn propose(&mut self, seen: &Observation<'_>) -> Proposal {
        let s = &self.settings;
        let gain = s.gain_estimate;
        let first = s.mean_start && !self.started;
        let (l1, l2) = if first { (1.0, 0.0) } else { (s.level_weight, s.trend_weight) };
        for (station, m) in self.stations.iter_mut().zip(disturbance(seen, gain)) {
            let innovation = m - station.level;
            station.trend += l2 * (innovation - station.trend);
            station.level += l1 * innovation;
        }
        self.started = true;
        self.stations.iter().map(|s| (s.level + s.trend) / gain).collect::<Vec<_>>().into()
    }
}
