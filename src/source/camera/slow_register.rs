//! A register that changes slowly, read again while frames come.

use std::time::{Duration, Instant};

use super::features::Features;

/// Time from one reading of the speed of the spindle to the next: it counts whole turns between two
/// frames, which a spindle that gathers speed for a second makes few of.
pub(super) const SPEED_PERIOD: Duration = Duration::from_secs(1);
/// Time from one reading of the head's temperature to the next: half of what a temperature holds
/// for.
pub(super) const TEMPERATURE_PERIOD: Duration = Duration::from_secs(5);
/// Degrees a second of one turn a minute.
pub(super) const DEG_PER_S: f64 = 6.0;

/// A feature of the camera, and its value when it was read last.
#[derive(Clone, Debug)]
pub(super) struct SlowRegister {
    name: &'static str,
    period: Duration,
    read: Option<Instant>,
    value: Option<f64>,
}

impl SlowRegister {
    /// A feature that is read once a period at most: every reading is a round trip on the control
    /// channel.
    pub(super) fn new(name: &'static str, period: Duration) -> Self {
        Self { name, period, read: None, value: None }
    }

    /// Its value, at most a period old; `None` where the camera has no such feature, or does not
    /// answer.
    pub(super) fn value(&mut self, camera: &impl Features, now: Instant) -> Option<f64> {
        if self.read.is_none_or(|read| now.saturating_duration_since(read) >= self.period) {
            (self.read, self.value) = (Some(now), camera.number(self.name).filter(|v| v.is_finite()));
        }
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::super::features::Stated;
    use super::*;

    #[test]
    fn a_register_is_read_once_a_period_and_a_camera_without_it_has_none() {
        let (now, second) = (Instant::now(), Duration::from_secs(1));
        let mut speed = SlowRegister::new("SpindleSpeed", second);
        let camera = |rpm: &str| Stated::of(&[("SpindleSpeed", rpm)]);
        assert_eq!(speed.value(&camera("600"), now), Some(600.0));
        assert_eq!(speed.value(&camera("700"), now + second / 2), Some(600.0));
        assert_eq!(speed.value(&camera("700"), now + second), Some(700.0));
        assert_eq!(speed.value(&Stated::default(), now + 2 * second), None);
    }
}
