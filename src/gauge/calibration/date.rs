//! Calendar dates (ISO 8601, proleptic Gregorian): what a certificate's validity needs, and no
//! more.

use std::fmt;
use std::str::FromStr;
use std::time::SystemTime;

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A day, counted from 1970-01-01.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Date {
    days: i64,
}

/// What is no date.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{text:?} is no date; right would be YYYY-MM-DD, for instance 2026-11-22")]
pub struct DateError {
    text: String,
}

impl Date {
    /// The day a clock shows, in UTC.
    pub(crate) fn of(time: SystemTime) -> Self {
        let seconds = time.duration_since(SystemTime::UNIX_EPOCH).map_or(0, |d| d.as_secs());
        Self { days: (seconds / 86_400).cast_signed() }
    }

    /// The day so many days later.
    #[must_use]
    pub(crate) fn plus_days(self, days: u32) -> Self {
        Self { days: self.days + i64::from(days) }
    }

    /// Days from another date to this one.
    pub(crate) fn days_since(self, earlier: Self) -> i64 {
        self.days - earlier.days
    }

    /// Year, month, day (Hinnant, "chrono-compatible low-level date algorithms": eras of 400 years
    /// from March).
    fn civil(self) -> (i64, i64, i64) {
        let shifted = self.days + 719_468;
        let era = shifted.div_euclid(146_097);
        let of_era = shifted.rem_euclid(146_097);
        let year = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
        let of_year = of_era - (365 * year + year / 4 - year / 100);
        let march = (5 * of_year + 2) / 153;
        let day = of_year - (153 * march + 2) / 5 + 1;
        let month = if march < 10 { march + 3 } else { march - 9 };
        (year + 400 * era + i64::from(month <= 2), month, day)
    }

    fn from_civil(year: i64, month: i64, day: i64) -> Self {
        let year = year - i64::from(month <= 2);
        let era = year.div_euclid(400);
        let of_era = year.rem_euclid(400);
        let of_year = (153 * (if month > 2 { month - 3 } else { month + 9 }) + 2) / 5 + day - 1;
        Self { days: era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468 }
    }
}

impl fmt::Display for Date {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (year, month, day) = self.civil();
        write!(f, "{year:04}-{month:02}-{day:02}")
    }
}

impl FromStr for Date {
    type Err = DateError;

    fn from_str(text: &str) -> Result<Self, DateError> {
        let wrong = || DateError { text: text.to_owned() };
        let parts: Vec<&str> = text.split('-').collect();
        let [year, month, day] = parts[..] else { return Err(wrong()) };
        if (year.len(), month.len(), day.len()) != (4, 2, 2) {
            return Err(wrong());
        }
        let number = |t: &str| t.parse::<u16>().map(i64::from).map_err(|_| wrong());
        let (year, month, day) = (number(year)?, number(month)?, number(day)?);
        let date = Self::from_civil(year, month, day);
        // A day that does not exist comes back as another one.
        if (1..=12).contains(&month) && date.civil() == (year, month, day) { Ok(date) } else { Err(wrong()) }
    }
}

impl TryFrom<String> for Date {
    type Error = DateError;

    fn try_from(text: String) -> Result<Self, DateError> {
        text.parse()
    }
}

impl From<Date> for String {
    fn from(date: Date) -> Self {
        date.to_string()
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn days_are_those_of_the_calendar() {
        for (text, days) in
            [("1970-01-01", 0), ("2000-02-29", 11_016), ("2026-11-22", 20_779), ("2100-03-01", 47_541)]
        {
            let date: Date = text.parse().unwrap();
            assert_eq!((date.days, date.to_string()), (days, text.to_owned()));
        }
        let clock = SystemTime::UNIX_EPOCH + Duration::from_secs(20_779 * 86_400 + 5);
        assert_eq!(Date::of(clock).to_string(), "2026-11-22");
        assert_eq!("2026-12-30".parse::<Date>().unwrap().plus_days(3).to_string(), "2027-01-02");
    }

    #[test]
    fn what_is_no_day_is_refused() {
        for text in ["", "2026-13-01", "2025-02-29", "2026-1-1", "22.11.2026", "2026-04-31", "2026-00-10"] {
            assert!(text.parse::<Date>().is_err(), "{text}");
        }
    }
}
