//! A head that is commanded by the names of its features and takes frames trigger by trigger: what
//! a cell asks of it, whatever client is behind.

use std::time::Duration;

use thiserror::Error;

use crate::frame::Frame;

/// Why a head did not do what it was commanded.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub(crate) enum HeadError {
    /// A feature that was not set.
    #[error("{feature} cannot be set to {value}: {why}")]
    NotSet {
        /// Name of the feature.
        feature: String,
        /// The value.
        value: String,
        /// Why not.
        why: String,
    },
    /// A command that was not executed, and acquisition that did not start or stop.
    #[error("{command} was not executed: {why}")]
    NotExecuted {
        /// Name of the command.
        command: String,
        /// Why not.
        why: String,
    },
    /// It refused what it was asked for, in its own words.
    #[error("the head refuses: {0}")]
    Refused(String),
    /// It has no latch for its clock, by which frames belong to their triggers.
    #[error("its clock cannot be latched (TimestampLatch): a frame cannot be kept apart from an earlier one")]
    NoClock,
    /// It is gone, or another program has control.
    #[error("the head is gone: {0}")]
    Gone(String),
}

/// Place that a frame states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    /// Machine z of the image's central column, mm.
    pub z_mm: f64,
    /// Spindle angle, degrees.
    pub angle_deg: f64,
}

/// A whole frame of a head.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct HeadFrame {
    /// The frame; its number is not set.
    pub frame: Frame,
    /// Place by its chunks; `None` where it has none.
    pub place: Option<Place>,
    /// Start of exposure on the head's clock, ns.
    pub exposed_ns: Option<u64>,
}

/// What came within the time that was waited.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Arrived {
    /// A whole frame.
    Frame(Box<HeadFrame>),
    /// A frame that is not whole, and why.
    Incomplete(String),
    /// Nothing.
    Nothing,
}

/// A head under control.
pub(crate) trait CommandedHead: Send {
    /// The value of a feature as text; `None` where there is no such feature, or it has none.
    fn value(&self, feature: &str) -> Option<String>;

    /// Sets a feature.
    ///
    /// # Errors
    /// A value that is refused; a head that is gone.
    fn set(&mut self, feature: &str, value: &str) -> Result<(), HeadError>;

    /// Sets a feature that has its present value again at the end.
    ///
    /// # Errors
    /// As [`Self::set`].
    fn set_until_end(&mut self, feature: &str, value: &str) -> Result<(), HeadError>;

    /// Executes a command.
    ///
    /// # Errors
    /// A command that is refused; a head that is gone.
    fn execute(&mut self, command: &str) -> Result<(), HeadError>;

    /// Begins to acquire, by triggers where `TriggerMode` is on.
    ///
    /// # Errors
    /// As [`Self::execute`].
    fn start(&mut self) -> Result<(), HeadError>;

    /// Ceases to acquire: features that are set at rest can be set.
    ///
    /// # Errors
    /// As [`Self::execute`].
    fn stop(&mut self) -> Result<(), HeadError>;

    /// What comes next, after waiting at most so long.
    ///
    /// # Errors
    /// A stream that ended.
    fn receive(&mut self, wait: Duration) -> Result<Arrived, HeadError>;

    /// Asks whether it is there and obeys this program.
    ///
    /// # Errors
    /// [`HeadError::Gone`], with the reason.
    fn check(&self) -> Result<(), HeadError>;

    /// The clock that frames are stamped with, latched now, ns; `None` where there is no latch.
    fn now_ns(&self) -> Option<u64>;

    /// Takes the memory of a measured frame back.
    fn recycle(&mut self, _frame: Frame) {}

    /// The value of a feature as a number.
    fn number(&self, feature: &str) -> Option<f64> {
        self.value(feature)?.trim().parse().ok()
    }
}
