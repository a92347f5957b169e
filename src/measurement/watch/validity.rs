//! Whether what is shown may be read as the diameter of now.

use std::fmt;

/// Why there is no valid reading; the last good value does not stand in for it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Invalid {
    /// No frame has come yet.
    NoFrame,
    /// The last frame could not be measured, and why.
    Refused(String),
    /// The diameter has not settled yet, and why.
    NotSettled(String),
    /// The last frame is older than a reading may be, s.
    Stale(f64),
    /// The source disappeared, and why.
    SourceLost(String),
}

impl Invalid {
    /// Its word in JSON.
    pub(crate) fn word(&self) -> &'static str {
        match self {
            Self::NoFrame => "no_frame",
            Self::Refused(_) => "refused",
            Self::NotSettled(_) => "not_settled",
            Self::Stale(_) => "stale",
            Self::SourceLost(_) => "source_lost",
        }
    }
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoFrame => write!(f, "no frame yet"),
            Self::Refused(why) => write!(f, "{why}"),
            Self::NotSettled(why) => write!(f, "the diameter has not settled: {why}"),
            Self::Stale(age_s) => write!(f, "no frame for {age_s:.1} s"),
            Self::SourceLost(why) => write!(f, "the source is gone: {why}"),
        }
    }
}

/// The state of the last reading.
#[derive(Clone, Debug)]
pub(crate) struct Validity {
    stale_s: f64,
    /// Time of the last frame, s, and why its value is none of now.
    last: Option<(f64, Option<Invalid>)>,
    lost: Option<String>,
}

impl Validity {
    /// Readings older than `stale_s` are invalid.
    pub(crate) fn new(stale_s: f64) -> Self {
        Self { stale_s, last: None, lost: None }
    }

    /// A frame came at `t_s`; why it has no valid value, if it has none.
    pub(crate) fn frame(&mut self, t_s: f64, invalid: Option<Invalid>) {
        self.last = Some((t_s, invalid));
        self.lost = None;
    }

    /// The source disappeared.
    pub(crate) fn lost(&mut self, why: String) {
        self.lost = Some(why);
    }

    /// Time since the last frame, s; `None` before the first.
    pub(crate) fn age_s(&self, now_s: f64) -> Option<f64> {
        self.last.as_ref().map(|(t_s, _)| now_s - t_s)
    }

    /// Why the last reading is none of now.
    pub(crate) fn invalid(&self, now_s: f64) -> Option<Invalid> {
        if let Some(why) = &self.lost {
            return Some(Invalid::SourceLost(why.clone()));
        }
        match &self.last {
            None => Some(Invalid::NoFrame),
            Some((t_s, _)) if now_s - t_s > self.stale_s => Some(Invalid::Stale(now_s - t_s)),
            Some((_, invalid)) => invalid.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_fresh_measured_frame_is_valid() {
        let mut validity = Validity::new(1.0);
        assert_eq!(validity.invalid(0.0), Some(Invalid::NoFrame));
        validity.frame(10.0, None);
        assert_eq!((validity.invalid(10.9), validity.age_s(10.5)), (None, Some(0.5)));
        assert_eq!(validity.invalid(12.0), Some(Invalid::Stale(2.0)));
        let refused = Invalid::Refused("blurred".to_owned());
        validity.frame(12.0, Some(refused.clone()));
        assert_eq!(validity.invalid(12.0), Some(refused));
        validity.frame(12.5, Some(Invalid::NotSettled("it cools".to_owned())));
        assert_eq!(validity.invalid(12.5).map(|i| i.word()), Some("not_settled"));
        validity.frame(13.0, None);
        validity.lost("no answer".to_owned());
        assert_eq!(validity.invalid(13.0).map(|i| i.word()), Some("source_lost"));
        // It is back.
        validity.frame(14.0, None);
        assert_eq!(validity.invalid(14.0), None);
    }
}
