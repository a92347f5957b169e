//! A GigE Vision camera as a source of commands, where the program has cameras at all.

use crate::cli::failure::Failure;
#[cfg(feature = "camera")]
use crate::source::camera::{Camera, CameraSettings, WhenGone};
use crate::source::live::Producer;

/// A camera as it is asked for.
#[derive(Debug)]
#[cfg_attr(
    not(feature = "camera"),
    allow(dead_code, reason = "a program without cameras refuses it by its name")
)]
pub(crate) struct CameraSource {
    /// IPv4 address, serial number or user-defined name.
    pub(super) name: String,
    /// Exposure time to set, µs.
    pub(super) exposure_us: Option<f64>,
    /// Gain to set, dB.
    pub(super) gain_db: Option<f64>,
}

impl CameraSource {
    /// The camera, open; one that is gone later returns, or ends the source.
    ///
    /// # Errors
    /// No such camera, a busy one, one that is set to what is not measured.
    #[cfg(feature = "camera")]
    pub(super) fn producer(self, returns: bool) -> Result<Box<dyn Producer>, Failure> {
        let Self { name, exposure_us, gain_db } = self;
        let when_gone = if returns { WhenGone::Returns } else { WhenGone::Ends };
        let camera = Camera::open(&name, CameraSettings { exposure_us, gain_db, when_gone });
        Ok(Box::new(camera.map_err(|why| Failure::fail(format!("gige:{name}: {why}")))?))
    }

    /// Refuses: there is no client in this build.
    ///
    /// # Errors
    /// Always.
    #[cfg(not(feature = "camera"))]
    pub(super) fn producer(self, _returns: bool) -> Result<Box<dyn Producer>, Failure> {
        let name = self.name;
        Err(Failure::refuse(format!(
            "gige:{name}: this program was built without the feature camera; build it with it, pipe the camera's frames \
             into raw:- or follow the folder that it writes to"
        )))
    }
}
