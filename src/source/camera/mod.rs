//! GigE Vision and USB3 Vision cameras as live sources, by the crate `viva-genicam`, which nothing
//! outside this folder names.
//!
//! In: an IPv4 address, a serial number or a user-defined name; exposure and gain where they are
//! to be set. Out: [`Camera`], a [`Producer`](super::live::Producer) of whole frames in the
//! camera's own depth, with the device's and the host's time apart and the values of its chunks,
//! and what a calibration of them is bound to (`binding`). `find` is discovery, `features` access
//! by name, `guard` what alters grey values and is set off, refused and restored, `image` the seven
//! pixel formats, `ids` block ids to numbers, `chunks` and `clock` what comes beside the pixels,
//! `last_packet` asks for trailers that were lost, `latched_angle` angles at mid-exposure,
//! `watchdog` when a silent camera is asked, `setup` what a camera is set to before it acquires;
//! `session` joins them from opening to closing, `link` is what a live camera asks of the link to
//! it (`gige_link`; `usb`, feature `camera-usb`), `live_camera` opens again a camera that was away,
//! `commanded` is a camera with a process behind it, commanded by its features and triggers;
//! `listed` are cameras by network interface and `test_packet` whether their packets arrive. One
//! more feature that alters grey values is a line in `guard`, one more link a file with a `Link`.

#![cfg_attr(
    not(feature = "cli"),
    allow(dead_code, unused_imports, reason = "the program opens cameras; the library alone does not")
)]

mod binding;
mod chunks;
mod clock;
mod commanded;
mod error;
mod features;
mod find;
mod gige_link;
mod guard;
mod ids;
mod image;
mod last_packet;
mod latched_angle;
mod link;
mod listed;
mod live_camera;
mod session;
mod settings;
mod setup;
mod slow_register;
mod test_packet;
#[cfg(feature = "camera-usb")]
mod usb;
mod watchdog;

pub(crate) use self::commanded::CommandedCamera;
pub(crate) use self::listed::{AccessStatus, FoundCamera, NetworkInterface, interfaces};
pub(crate) use self::live_camera::Camera;
pub(crate) use self::settings::{CameraSettings, FeatureSetting, WhenGone};
pub(crate) use self::test_packet::{TestPackets, test_packets};
#[cfg(feature = "camera-usb")]
pub(crate) use self::usb::UsbCamera;
