//! Times as the store has them: milliseconds since 1970 in UTC, shown as ISO 8601.

use std::fmt;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use crate::gauge::calibration::Date;

const DAY_MS: i64 = 86_400_000;

/// An instant, ms since 1970-01-01 in UTC.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(transparent)]
pub(crate) struct Utc(pub i64);

impl Utc {
    /// The instant that this machine's clock shows.
    pub(crate) fn now() -> Self {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self(i64::try_from(since.as_millis()).unwrap_or(i64::MAX))
    }

    /// Midnight at the beginning of a day.
    pub(crate) fn at_beginning_of(day: Date) -> Self {
        Self(day.days_since(Date::of(UNIX_EPOCH)) * DAY_MS)
    }
}

impl fmt::Display for Utc {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let day = Duration::from_secs((self.0.div_euclid(DAY_MS) * (DAY_MS / 1000)).max(0).cast_unsigned());
        let ms = self.0.rem_euclid(DAY_MS);
        let (h, m, s) = (ms / 3_600_000, ms / 60_000 % 60, ms / 1000 % 60);
        write!(f, "{}T{h:02}:{m:02}:{s:02}.{:03}Z", Date::of(UNIX_EPOCH + day), ms % 1000)
    }
}

#[cfg(test)]
mod tests {
    use super::Utc;

    /// 1 000 000 000 s after 1970 is 2001-09-09T01:46:40Z.
    #[test]
    fn an_instant_is_shown_as_iso_8601() {
        assert_eq!(Utc(1_000_000_000_123).to_string(), "2001-09-09T01:46:40.123Z");
        assert_eq!(
            Utc::at_beginning_of("2001-09-09".parse().unwrap()).to_string(),
            "2001-09-09T00:00:00.000Z"
        );
    }
}
