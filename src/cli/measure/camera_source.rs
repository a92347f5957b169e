//! A GigE Vision or USB3 Vision camera as a source of commands, where the program has such at all.

use crate::cli::failure::Failure;
#[cfg(feature = "camera-usb")]
use crate::source::camera::UsbCamera;
#[cfg(feature = "camera")]
use crate::source::camera::{Camera, CameraSettings, FeatureSetting, WhenGone};
use crate::source::live::Producer;

/// A camera as it is asked for.
#[derive(Debug)]
#[cfg_attr(
    not(feature = "camera"),
    allow(dead_code, reason = "a program without cameras refuses it by its name")
)]
pub(crate) struct CameraSource {
    /// `gige` or `usb`.
    pub(super) link: &'static str,
    /// USB3 Vision: serial number; else IPv4 address, serial number or user-defined name.
    pub(super) name: String,
    /// Exposure time to set, µs.
    pub(super) exposure_us: Option<f64>,
    /// Gain to set, dB.
    pub(super) gain_db: Option<f64>,
    /// Features to set, `NAME=VALUE`.
    pub(super) features: Vec<String>,
    /// Whether rows may be exposed one after another.
    pub(super) accepts_rolling_shutter: bool,
}

impl CameraSource {
    /// The camera, open; one that is gone later returns, or ends the source.
    ///
    /// # Errors
    /// No such camera, a busy one, one that is set to what is not measured.
    #[cfg(feature = "camera")]
    pub(super) fn producer(self, returns: bool) -> Result<Box<dyn Producer>, Failure> {
        let Self { link, ref name, exposure_us, gain_db, accepts_rolling_shutter, .. } = self;
        let features = feature_settings(&self.features)?;
        let when_gone = if returns { WhenGone::Returns } else { WhenGone::Ends };
        let settings = CameraSettings { exposure_us, gain_db, features, accepts_rolling_shutter, when_gone };
        if link == "usb" {
            return self.usb_producer(settings);
        }
        let camera = Camera::open(name, settings);
        Ok(Box::new(camera.map_err(|why| Failure::fail(format!("gige:{name}: {why}")))?))
    }

    #[cfg(feature = "camera-usb")]
    fn usb_producer(&self, settings: CameraSettings) -> Result<Box<dyn Producer>, Failure> {
        let camera = UsbCamera::open(&self.name, settings);
        Ok(Box::new(camera.map_err(|why| Failure::fail(format!("usb:{}: {why}", self.name)))?))
    }

    #[cfg(all(feature = "camera", not(feature = "camera-usb")))]
    fn usb_producer(&self, _settings: CameraSettings) -> Result<Box<dyn Producer>, Failure> {
        Err(Failure::refuse(format!(
            "usb:{}: this program was built without the feature camera-usb; build it with it, pipe the camera's frames \
             into raw:- or follow the folder that it writes to",
            self.name
        )))
    }

    /// Refuses: there is no client in this build.
    ///
    /// # Errors
    /// Always.
    #[cfg(not(feature = "camera"))]
    pub(super) fn producer(self, _returns: bool) -> Result<Box<dyn Producer>, Failure> {
        let Self { link, name, .. } = self;
        Err(Failure::refuse(format!(
            "{link}:{name}: this program was built without the feature camera; build it with it, pipe the camera's frames \
             into raw:- or follow the folder that it writes to"
        )))
    }
}

/// Features as they were given.
///
/// # Errors
/// What is no `NAME=VALUE`.
#[cfg(feature = "camera")]
pub(crate) fn feature_settings(given: &[String]) -> Result<Vec<FeatureSetting>, Failure> {
    let parsed =
        |text: &String| text.parse().map_err(|why| Failure::refuse(format!("--feature {text}: {why}")));
    given.iter().map(parsed).collect()
}
