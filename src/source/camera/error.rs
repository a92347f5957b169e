//! Why a camera is refused.

use thiserror::Error;

/// Why a camera cannot be opened; each names the camera or the feature and what would be right.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub(crate) enum CameraError {
    /// Nothing answers at an address.
    #[error(
        "no GigE Vision camera answers at {0}: it is off, in another subnet, or a firewall drops UDP port 3956"
    )]
    NoAnswer(std::net::Ipv4Addr),
    /// No camera of a name; with those that answered.
    #[error("no GigE Vision camera has the serial number or the user-defined name \"{name}\"; {found}")]
    NoSuchName {
        /// The name.
        name: String,
        /// What answered, in words.
        found: String,
    },
    /// No camera at a USB port has a serial number.
    #[cfg(feature = "camera-usb")]
    #[error("no USB3 Vision camera has the serial number \"{name}\"; {found}")]
    NoSuchUsb {
        /// The serial number.
        name: String,
        /// What is plugged in, in words.
        found: String,
    },
    /// Several cameras of a name.
    #[error("{count} cameras have the name \"{name}\": give the serial number or the IP address; {found}")]
    NotOne {
        /// The name.
        name: String,
        /// How many.
        count: usize,
        /// What answered, in words.
        found: String,
    },
    /// Another program has control.
    #[error("the camera is busy: another program has control of it; end that one")]
    Busy,
    /// A step that failed, with the cause.
    #[error("{step}: {cause}")]
    Failed {
        /// What was tried.
        step: &'static str,
        /// Why it failed.
        cause: String,
    },
    /// A feature that alters grey values or geometry.
    #[error("{feature} is {found}: {why}; set it to {right}")]
    Refused {
        /// Name of the feature.
        feature: String,
        /// Its value.
        found: String,
        /// What it does to the frames.
        why: &'static str,
        /// The value that is right.
        right: &'static str,
    },
    /// A setting that the frames before had otherwise.
    #[error("{feature} is {found}, and was {was}: frames of one series are taken alike")]
    Otherwise {
        /// The setting.
        feature: &'static str,
        /// What it was.
        was: String,
        /// What it is.
        found: String,
    },
    /// A feature that was to be set.
    #[error("{feature} cannot be set to {value}: {cause}")]
    NotSet {
        /// Name of the feature.
        feature: String,
        /// The value.
        value: String,
        /// Why not.
        cause: String,
    },
    /// A format that is not read.
    #[error("PixelFormat is {found}; {SUPPORTED} are measured{offered}")]
    Format {
        /// The camera's format.
        found: String,
        /// Which of those the camera has, in words.
        offered: String,
    },
}

/// Pixel formats that are measured, by their names in PFNC.
pub(super) const SUPPORTED: &str = "Mono8, Mono10, Mono10p, Mono12, Mono12p, Mono12Packed and Mono16";

impl CameraError {
    /// A step that failed.
    pub(super) fn failed(step: &'static str, cause: impl std::fmt::Display) -> Self {
        Self::Failed { step, cause: cause.to_string() }
    }
}
