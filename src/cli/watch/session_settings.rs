//! What a session is given, and what stands beside its measurement.

use std::time::Duration;

use super::live_conditions::LiveConditions;
use super::on_alarm::OnAlarm;
use super::picture::Picture;
use super::setup_page::SetupPage;

/// What a session is given.
#[derive(Debug)]
pub(super) struct SessionSettings {
    /// Time without a frame that ends it.
    pub(super) idle: Option<Duration>,
    /// Age from which a reading is none of now.
    pub(super) stale: Duration,
    /// Name of the source in messages.
    pub(super) name: String,
    /// Whether what must agree are means of whole turns, by the frames' angles.
    pub(super) turning: bool,
    /// Whether the shaft stands upright in the images.
    pub(super) vertical: bool,
    /// Scale of the profile: mm per pixel, or 1 in pixels.
    pub(super) scale: f64,
    /// Whether frames are corrected by a flat field: what is saved is the frame before.
    pub(super) corrects: bool,
}

/// What stands beside the measurement.
pub(super) struct Beside {
    /// The command of the alarm.
    pub(super) on_alarm: OnAlarm,
    /// Temperatures and zeros.
    pub(super) conditions: LiveConditions,
    /// The page of `--setup`.
    pub(super) setup: Option<SetupPage>,
    /// The picture of `--picture`.
    pub(super) picture: Option<Picture>,
}
