//! The alarm: raised once, and never taken back. It is no safety function: nothing here is
//! redundant, and a computer that stands still raises none.

/// An alarm with its first cause.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Alarm {
    cause: Option<String>,
}

impl Alarm {
    /// Raises it; whether this is the first time.
    pub(crate) fn raise(&mut self, cause: impl FnOnce() -> String) -> bool {
        let is_first = self.cause.is_none();
        self.cause.get_or_insert_with(cause);
        is_first
    }

    /// The first cause, where it was raised.
    pub(crate) fn cause(&self) -> Option<&str> {
        self.cause.as_deref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_cause_stays() {
        let mut alarm = Alarm::default();
        assert_eq!(alarm.cause(), None);
        assert!(alarm.raise(|| "a".to_owned()) && !alarm.raise(|| "b".to_owned()));
        assert_eq!(alarm.cause(), Some("a"));
    }
}
