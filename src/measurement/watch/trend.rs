//! The slope of a diameter over the last readings: a part that cools, a film that runs off.

use std::collections::VecDeque;

/// Readings that a slope is of.
const READINGS: usize = 64;
/// Fewest readings of a slope: its scatter has eight degrees of freedom then.
const LEAST: usize = 10;
/// Standard uncertainties from which a slope is a trend: scatter alone exceeds that in one of 370
/// windows of many readings, in one of 59 of the fewest (Student's t, 8 degrees of freedom).
const TREND: f64 = 3.0;

/// A slope with its standard uncertainty from the scatter about the line, a minute.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slope {
    /// Change of the value a minute.
    pub per_minute: f64,
    /// Standard uncertainty of it.
    pub u_per_minute: f64,
}

impl Slope {
    /// Whether it exceeds what scatter explains.
    pub(crate) fn is_trend(&self) -> bool {
        self.per_minute.abs() > TREND * self.u_per_minute
    }
}

/// The last readings of one part.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trend {
    readings: VecDeque<[f64; 2]>,
}

impl Trend {
    /// A value at a time, s.
    pub(crate) fn push(&mut self, t_s: f64, value: f64) {
        if self.readings.len() == READINGS {
            self.readings.pop_front();
        }
        self.readings.push_back([t_s, value]);
    }

    /// Begins anew: another part.
    pub(crate) fn clear(&mut self) {
        self.readings.clear();
    }

    /// The least-squares slope; `None` of too few readings, or of readings at one time.
    pub(crate) fn slope(&self) -> Option<Slope> {
        if self.readings.len() < LEAST {
            return None;
        }
        let count = self.readings.len() as f64;
        let mean = |k: usize| self.readings.iter().map(|r| r[k]).sum::<f64>() / count;
        let (t, d) = (mean(0), mean(1));
        let sum =
            |f: &dyn Fn(f64, f64) -> f64| self.readings.iter().map(|r| f(r[0] - t, r[1] - d)).sum::<f64>();
        let spread = sum(&|t, _| t * t);
        if !(spread > 0.0) {
            return None;
        }
        let slope = sum(&|t, d| t * d) / spread;
        let residual = sum(&|t, d| (d - slope * t).powi(2)) / (count - 2.0);
        Some(Slope { per_minute: 60.0 * slope, u_per_minute: 60.0 * (residual / spread).sqrt() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_and_the_textbook_uncertainty() {
        let mut trend = Trend::default();
        (0..9).for_each(|k| trend.push(f64::from(k), 1.0));
        assert_eq!(trend.slope(), None);
        trend.clear();
        // Slope .25 a second with residuals ±.1 that are orthogonal to 1 and t: u² = 20·.01/18/Σt².
        for k in 0..20 {
            let sign = if matches!(k % 4, 0 | 3) { 0.1 } else { -0.1 };
            trend.push(100.0 + f64::from(k), 7.0 + 0.25 * f64::from(k) + sign);
        }
        let slope = trend.slope().unwrap();
        let spread: f64 = (0..20).map(|k| (f64::from(k) - 9.5).powi(2)).sum();
        assert!((slope.per_minute - 15.0).abs() < 1e-9, "{slope:?}");
        assert!((slope.u_per_minute - 60.0 * (0.2 / 18.0 / spread).sqrt()).abs() < 1e-9, "{slope:?}");
        assert!(slope.is_trend());
    }

    #[test]
    fn the_past_is_forgotten_and_scatter_is_no_trend() {
        let mut trend = Trend::default();
        (0..50).for_each(|k| trend.push(f64::from(k), f64::from(k)));
        (50..50 + READINGS as i32)
            .for_each(|k| trend.push(f64::from(k), if k % 2 == 0 { 0.01 } else { -0.01 }));
        assert!(!trend.slope().unwrap().is_trend());
        trend.clear();
        (0..20).for_each(|_| trend.push(3.0, 1.0));
        assert_eq!(trend.slope(), None);
    }
}
