//! Ranges of the settings below `[process]`.

use std::fmt::Display;

use crate::setting::SettingError;

/// The error for a value that is out of range for a key below `[process]`.
pub(super) fn refuse(key: &str, value: impl Display, right: impl Display) -> SettingError {
    SettingError::of(format!("process.{key}"), value, right)
}

/// A range that a number must lie in.
#[derive(Clone, Copy, Debug)]
pub(super) struct Range {
    low: f64,
    open_low: bool,
    high: f64,
    infinite: bool,
}

impl Range {
    /// Above zero.
    pub(super) const POSITIVE: Self = Self { low: 0.0, open_low: true, high: f64::INFINITY, infinite: false };
    /// Zero or above.
    pub(super) const NOT_NEGATIVE: Self = Self { open_low: false, ..Self::POSITIVE };

    /// Both ends included.
    pub(super) const fn between(low: f64, high: f64) -> Self {
        Self { low, open_low: false, high, infinite: false }
    }

    /// Allows `inf` as well.
    pub(super) const fn or_infinite(self) -> Self {
        Self { infinite: true, ..self }
    }

    fn holds(&self, value: f64) -> bool {
        let above = if self.open_low { value > self.low } else { value >= self.low };
        above && value <= self.high && (self.infinite || value.is_finite())
    }

    fn text(&self) -> String {
        let low = if self.open_low { "above" } else { "at least" };
        let high = if self.high.is_finite() { format!(" and at most {}", self.high) } else { String::new() };
        let or = if self.infinite { " or inf" } else { "" };
        format!("{low} {}{high}{or}", self.low)
    }

    /// Refuses a value outside the range.
    pub(super) fn check(&self, key: &str, value: f64) -> Result<(), SettingError> {
        if self.holds(value) { Ok(()) } else { Err(refuse(key, value, self.text())) }
    }
}
