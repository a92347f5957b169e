//! How the camera of a calibration is set, and whether anyone is asked.

#[cfg(feature = "camera")]
use crate::cli::failure::Failure;
#[cfg(feature = "camera")]
use crate::cli::measure::camera_source::feature_settings;
#[cfg(feature = "camera")]
use crate::source::camera::{CameraSettings, WhenGone};

use crate::cli::measure::input::{exposure_us, gain_db};

/// Arguments of a camera (`source = "gige:…"` in the config).
#[derive(Debug, Default, clap::Args)]
pub(crate) struct CameraArgs {
    /// Exposure time that the config's camera is set to, µs; it has its own back at the end.
    #[arg(long, value_name = "US", value_parser = exposure_us)]
    pub(super) exposure_us: Option<f64>,
    /// Gain that the config's camera is set to, dB; it has its own back at the end. Frames are
    /// measured by the calibration with this gain alone.
    #[arg(long, value_name = "DB", value_parser = gain_db, allow_negative_numbers = true)]
    pub(super) gain_db: Option<f64>,
    /// Feature that the config's camera is set to, by its name (PixelFormat=Mono12); again for
    /// more. It has its own back at the end.
    #[arg(long = "feature", value_name = "NAME=VALUE")]
    pub(super) features: Vec<String>,
    /// Takes a camera whose shutter exposes row after row: masters at rest alone.
    #[arg(long)]
    pub(super) accept_rolling_shutter: bool,
    /// Asks for nothing on the terminal: of a camera that does not place dark, flat and pins itself
    /// (HeadObject, MasterIndex, as the published head does) nothing is taken.
    #[arg(long)]
    pub(super) yes: bool,
}

impl CameraArgs {
    /// The option of a camera that is given, for messages.
    pub(super) fn given(&self) -> Option<&'static str> {
        let exposure = self.exposure_us.map(|_| "--exposure-us");
        let shutter = self.accept_rolling_shutter.then_some("--accept-rolling-shutter");
        let feature = (!self.features.is_empty()).then_some("--feature");
        exposure.or(self.gain_db.map(|_| "--gain-db")).or(feature).or(shutter).or(self.yes.then_some("--yes"))
    }

    /// What the camera is opened with.
    ///
    /// # Errors
    /// What is no feature with its value.
    #[cfg(feature = "camera")]
    pub(super) fn settings(&self) -> Result<CameraSettings, Failure> {
        let Self { exposure_us, gain_db, accept_rolling_shutter: accepts_rolling_shutter, .. } = *self;
        let (features, when_gone) = (feature_settings(&self.features)?, WhenGone::Ends);
        Ok(CameraSettings { exposure_us, gain_db, features, accepts_rolling_shutter, when_gone })
    }
}
