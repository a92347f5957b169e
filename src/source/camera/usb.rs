//! USB3 Vision as the link to a live camera (feature `camera-usb`).
//!
//! Untested: no such camera, and no simulated one, could be had; of what is here the types alone
//! are checked. Features, formats, chunks, guards, the watchdog and the return of a camera are the
//! code of GigE Vision, which is tested. Times of blocks are nanoseconds of the camera (USB3 Vision
//! 1.1, leader) without a map to the host's clock, so that encoders beside the frames cannot be
//! bound to them.

use std::time::{Duration, Instant};

use viva_genicam::u3v::{NusbTransfer, U3vDeviceInfo, U3vError, discover};
use viva_genicam::{
    Camera, Frame as Block, GenicamError, U3vFrameStream, U3vRegisterIo, U3vStreamOptions, connect_u3v,
};

use super::binding::Identity;
use super::chunks::ChunkValues;
use super::error::CameraError;
use super::features::Features as _;
use super::find::the_one;
use super::guard::Restore;
use super::ids::Ids;
use super::link::{Link, Presence};
use super::live_camera::LiveCamera;
use super::settings::CameraSettings;
use super::setup::{Setup, set_up};
use super::slow_register::{DEG_PER_S, SPEED_PERIOD, SlowRegister, TEMPERATURE_PERIOD};
use crate::source::live::{Known, Provenance};

/// A USB3 Vision camera.
pub(crate) type UsbCamera = LiveCamera<UsbSession>;

type Device = Camera<U3vRegisterIo<NusbTransfer>>;

/// A USB3 Vision camera, open, with its stream.
pub(crate) struct UsbSession {
    // The stream ends before the camera is given up.
    stream: U3vFrameStream,
    camera: Device,
    setup: Setup,
    speed: SlowRegister,
    temperature: SlowRegister,
}

impl Link for UsbSession {
    type Device = U3vDeviceInfo;

    const TICKS_ARE_NS: bool = true;

    fn find(name: &str) -> Result<U3vDeviceInfo, CameraError> {
        let all = discover().map_err(|error| CameraError::failed("USB devices cannot be listed", error))?;
        named(name, all)
    }

    fn again(device: &U3vDeviceInfo) -> Option<U3vDeviceInfo> {
        discover().ok()?.into_iter().find(|found| Self::is_same(found, device))
    }

    fn shown(device: &U3vDeviceInfo) -> String {
        let of = |text: &Option<String>| text.clone().unwrap_or_default();
        format!(
            "{} {}, serial number {}, at USB bus {}",
            of(&device.manufacturer),
            of(&device.model),
            of(&device.serial),
            device.bus
        )
    }

    fn is_same(device: &U3vDeviceInfo, other: &U3vDeviceInfo) -> bool {
        (device.vendor_id, device.product_id, &device.serial)
            == (other.vendor_id, other.product_id, &other.serial)
    }

    fn open(
        device: &U3vDeviceInfo,
        settings: &CameraSettings,
        restore: &mut Restore,
    ) -> Result<Self, CameraError> {
        let mut camera = connect_u3v(device).map_err(of_connect)?;
        let identity = Identity { serial_number: device.serial.as_deref(), model: device.model.as_deref() };
        let opened = set_up(&mut camera, identity, settings, restore)
            .and_then(|setup| Ok((setup, stream(&mut camera)?)));
        match opened {
            Ok((setup, stream)) => {
                let speed = SlowRegister::new("SpindleSpeed", SPEED_PERIOD);
                let temperature = SlowRegister::new("DeviceTemperature", TEMPERATURE_PERIOD);
                Ok(Self { stream, camera, setup, speed, temperature })
            }
            Err(why) => {
                restore.give_back(&mut camera);
                Err(why)
            }
        }
    }

    fn setup(&self) -> &Setup {
        &self.setup
    }

    fn ids() -> Ids {
        Ids::of_64_bits_from_0()
    }

    fn introduced(&self) -> String {
        "by USB3 Vision, which is untested; its clock is not mapped".to_owned()
    }

    fn start(&mut self) -> Result<(), CameraError> {
        self.camera.acquisition_start().map_err(|why| CameraError::failed("AcquisitionStart", why))
    }

    fn receive(&mut self, wait: Duration) -> Result<Option<Block>, String> {
        match self.stream.next_frame_blocking(wait) {
            Ok(Some(block)) => Ok(Some(block)),
            Ok(None) => Err("its stream ended".to_owned()),
            Err(GenicamError::Timeout(_)) => Ok(None),
            Err(GenicamError::U3v { source: U3vError::Disconnected, .. }) => {
                Err("it was unplugged or reset".to_owned())
            }
            Err(why) => Err(why.to_string()),
        }
    }

    fn values(&mut self, block: &Block) -> ChunkValues {
        self.setup.values(&mut self.camera, block)
    }

    fn spindle_deg_per_s(&mut self) -> Option<f64> {
        Some(DEG_PER_S * self.speed.value(&self.camera, Instant::now())?)
    }

    fn head_c(&mut self) -> Option<Known<f64>> {
        let value = self.temperature.value(&self.camera, Instant::now())?;
        Some(Known { value, provenance: Provenance::Register })
    }

    /// An open camera has no other client: one that answers a register obeys.
    fn presence(&self, _device: &U3vDeviceInfo) -> Presence {
        let answers = self.camera.value("Width").is_some() && !self.camera.transport().is_lost();
        if answers { Presence::Obeys } else { Presence::Absent }
    }

    fn no_frames(&self, silent_s: f64) -> String {
        format!(
            "it answers, but no frame came for {silent_s:.0} s: its cable or port carries less than USB 3, or its rate is 0"
        )
    }

    fn close(mut self, restore: &mut Restore) {
        if let Err(why) = self.camera.acquisition_stop() {
            tracing::debug!("AcquisitionStop: {why}");
        }
        drop(self.stream);
        restore.give_back(&mut self.camera);
    }
}

fn of_connect(error: GenicamError) -> CameraError {
    match error {
        // One client holds the interface.
        GenicamError::U3v { source: U3vError::Claim { .. }, .. } => CameraError::Busy,
        other => CameraError::failed("the camera cannot be opened", other),
    }
}

fn stream(camera: &mut Device) -> Result<U3vFrameStream, CameraError> {
    let payload_size_hint = camera.number("PayloadSize").map_or(0, |bytes| bytes as u64);
    let options = U3vStreamOptions { payload_size_hint, ..U3vStreamOptions::default() };
    let mut stream =
        camera.open_stream(options).map_err(|why| CameraError::failed("the stream cannot be opened", why))?;
    // They are counted and named, not measured.
    stream.set_deliver_incomplete(true);
    Ok(stream)
}

/// The one camera with a serial number.
fn named(name: &str, all: Vec<U3vDeviceInfo>) -> Result<U3vDeviceInfo, CameraError> {
    let words: Vec<String> = all.iter().map(UsbSession::shown).collect();
    let found = match words.is_empty() {
        true => "none is plugged in, or this user may not read its device".to_owned(),
        false => format!("there are {}", words.join("; ")),
    };
    let is_it = |camera: &U3vDeviceInfo| camera.serial.as_deref().is_some_and(|serial| serial.trim() == name);
    let of_name = all.into_iter().filter(is_it).collect();
    the_one(of_name, (name, found), |name, found| CameraError::NoSuchUsb { name, found })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(address: u8, serial: &str) -> U3vDeviceInfo {
        U3vDeviceInfo {
            bus: "2".to_owned(),
            address,
            vendor_id: 0x1234,
            product_id: 1,
            serial: Some(serial.to_owned()),
            manufacturer: None,
            model: Some("M".to_owned()),
            speed: None,
        }
    }

    #[test]
    fn a_name_is_the_serial_number_of_one_camera() {
        let all = || vec![camera(3, "70001"), camera(4, "70002")];
        assert_eq!(named("70002", all()).unwrap().address, 4);
        let why = named("70003", all()).unwrap_err().to_string();
        assert!(why.contains("\"70003\"") && why.contains("70001"), "{why}");
        assert!(named("70001", Vec::new()).unwrap_err().to_string().contains("none is plugged in"));
        assert!(UsbSession::is_same(&camera(3, "70001"), &camera(9, "70001")), "plugged in elsewhere");
    }
}
