//! What is computed of frames that are watched as they come, beside their measurement.
//!
//! In: values of frames with their times (numbers alone: whoever watches has the frames). Out: one
//! value a part that enters and leaves (`presence`), a trend with its uncertainty (`trend`),
//! quantiles of the latency and the rate (`pace`), whether a reading is valid (`validity`), the
//! drift since the last zero (`zero`), the diameters along the frame as text (`profile`) and the
//! latched alarm (`alarm`), the angles that a turn leaves out (`turn_cover`); `setup` is what
//! focus, light and alignment are set by, of pixels and edges. None imports another; one more
//! figure is a file here and a key of `cli/watch`.

mod alarm;
mod pace;
mod presence;
mod profile;
mod setup;
mod trend;
mod turn_cover;
mod validity;
mod zero;

pub(crate) use self::alarm::Alarm;
pub(crate) use self::pace::Pace;
pub(crate) use self::presence::{FrameValue, PartValue, Presence, Seen};
pub(crate) use self::profile::{Profile, profile};
pub(crate) use self::setup::SetupReading;
pub(crate) use self::trend::{Slope, Trend};
pub(crate) use self::turn_cover::{Turn, TurnCover};
pub(crate) use self::validity::{Invalid, Validity};
pub(crate) use self::zero::{Drift, Zero, Zeros};
