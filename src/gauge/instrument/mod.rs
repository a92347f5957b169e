//! The instrument as a whole: what all rooms of the gauge are put together to, and what they decide
//! by.
//!
//! `gauge` is the gauge that users begin with: in go checked
//! [`GaugeSettings`](crate::gauge::GaugeSettings), out come streams that measure frames by them.
//! `thresholds` lists every threshold of every room, for the study that varies them; one more group
//! is a line there.

mod gauge;
pub(crate) mod thresholds;

pub use self::gauge::Gauge;
