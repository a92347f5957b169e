//! The drift of a gauge since it was last set to zero, by a log of its zeros.

use std::fmt;

use crate::measurement::temperature::ZeroDrift;

/// Most zeros that are kept: at one an hour those of seven years. Of more the older half is let go.
const MOST: usize = 1 << 16;

/// A time at which the gauge was set to zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Zero {
    /// When, ns, on the clock of the frames.
    pub t_ns: u64,
    /// Temperature of the head then, °C, where it is known.
    pub head_c: Option<f64>,
}

/// Drift at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Drift {
    /// Time since the zero, s.
    pub since_s: f64,
    /// Change of the head's temperature since then, K; 0 where it is not asked for.
    pub head_k: f64,
    /// Standard uncertainty of a diameter by it, mm.
    pub u_mm: f64,
}

impl fmt::Display for Drift {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.2} h, head {:+.2} K", self.since_s / 3600.0, self.head_k)
    }
}

/// The zeros of a gauge, and how it drifts from each.
#[derive(Clone, Debug)]
pub(crate) struct Zeros {
    drift: ZeroDrift,
    zeros: Vec<Zero>,
}

impl Zeros {
    /// No zero yet.
    pub(crate) fn new(drift: ZeroDrift) -> Self {
        Self { drift, zeros: Vec::new() }
    }

    /// One more zero; one that is not later than the last is left out.
    pub(crate) fn push(&mut self, zero: Zero) {
        if self.zeros.last().is_some_and(|last| last.t_ns >= zero.t_ns) {
            return;
        }
        if self.zeros.len() == MOST {
            self.zeros.drain(..MOST / 2);
        }
        self.zeros.push(zero);
    }

    /// The drift at `t_ns` since the last zero before, with the head at `head_c`.
    ///
    /// # Errors
    /// No zero before, one whose interval is over, a head without a temperature where its drift
    /// depends on it.
    pub(crate) fn at(&self, t_ns: u64, head_c: Option<f64>) -> Result<Drift, String> {
        let before = self.zeros.partition_point(|zero| zero.t_ns <= t_ns);
        let Some(zero) = before.checked_sub(1).and_then(|i| self.zeros.get(i)) else {
            return Err(format!("the gauge was not set to zero before t_ns {t_ns}: measure the zero master"));
        };
        let since_s = 1e-9 * (t_ns - zero.t_ns) as f64;
        let head_k = match (self.drift.um_per_k > 0.0, head_c.zip(zero.head_c)) {
            (false, _) => 0.0,
            (true, Some((now_c, then_c))) => now_c - then_c,
            (true, None) => {
                return Err("the drift with the head's temperature is asked for (--zero-um-per-k): head_c is needed, now \
                            (--temperatures, --temperature-cmd, DeviceTemperature of the camera) and at the zero (--zero)"
                    .to_owned());
            }
        };
        Ok(Drift { since_s, head_k, u_mm: self.drift.u_mm(since_s, head_k)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOUR: u64 = 3_600_000_000_000;

    #[test]
    fn drift_is_that_since_the_last_zero_before() {
        let drift = ZeroDrift { um_per_h: 1.2, um_per_k: 0.5, interval_s: 7200.0 };
        let mut zeros = Zeros::new(drift);
        assert!(zeros.at(5, Some(20.0)).unwrap_err().contains("zero master"));
        for (hour, head_c) in [(1, 20.0), (4, 22.0), (4, 99.0), (3, 99.0)] {
            zeros.push(Zero { t_ns: hour * HOUR, head_c: Some(head_c) });
        }
        // 1.2 µm after an hour and .5 µm by one kelvin, as limits: 1.3 µm/√3.
        let two = zeros.at(2 * HOUR, Some(21.0)).unwrap();
        assert!((two.u_mm - 1.3e-3 / 3.0_f64.sqrt()).abs() < 1e-12, "{two:?}");
        assert_eq!(two.to_string(), "1.00 h, head +1.00 K");
        assert!(zeros.at(4 * HOUR - 1, Some(21.0)).unwrap_err().contains("again"));
        assert_eq!(zeros.at(4 * HOUR, Some(22.0)).unwrap().u_mm, 0.0);
        assert!(zeros.at(5 * HOUR, None).unwrap_err().contains("head_c"));
        // Where it does not depend on the head, its temperature is not needed.
        let mut by_time = Zeros::new(ZeroDrift { um_per_k: 0.0, ..drift });
        by_time.push(Zero { t_ns: 0, head_c: None });
        assert!((by_time.at(HOUR, None).unwrap().u_mm - 1.2e-3 / 3.0_f64.sqrt()).abs() < 1e-12);
    }
}
