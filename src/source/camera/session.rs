//! A camera from opening to closing: control, stream, and what was set.

use std::time::{Duration, Instant};

use viva_genicam::gencp::StatusCode;
use viva_genicam::gige::{DeviceInfo, GigeError, GigeStatus};
use viva_genicam::{ControlState, Frame as Block, FrameStream, GenicamError, StreamOptions, blocking};

use super::binding::Identity;
use super::chunks::ChunkValues;
use super::clock::DeviceClock;
use super::error::CameraError;
use super::features::{Device, Features};
use super::guard::Restore;
use super::last_packet::{LastPacket, Stated};
use super::settings::{CameraSettings, PACKET_SIZE};
use super::setup::{Setup, set_up};
use super::slow_register::{DEG_PER_S, SPEED_PERIOD, SlowRegister, TEMPERATURE_PERIOD};
use crate::source::live::{Known, Provenance};

/// A camera under control, with its stream open.
pub(crate) struct Session {
    // The stream ends before control is given up.
    stream: FrameStream,
    camera: Device,
    /// What it is set to.
    pub setup: Setup,
    /// Address and port at which frames are received, and bytes of a packet.
    pub receiver: (std::net::SocketAddrV4, u32),
    /// Asks for last packets; `None` where the camera sends none again.
    last_packet: Option<LastPacket>,
    speed: SlowRegister,
    temperature: SlowRegister,
}

impl Session {
    /// Takes control of a camera, sets it and opens its stream; nothing is acquired yet. Where
    /// that fails, what was set is restored.
    ///
    /// # Errors
    /// A camera that is busy, gone, or set to what is not measured.
    pub(super) fn open(
        device: &DeviceInfo,
        settings: &CameraSettings,
        restore: &mut Restore,
    ) -> Result<Self, CameraError> {
        let mut camera = blocking::connect(device).map_err(of_connect)?;
        let identity = Identity { serial_number: device.serial.as_deref(), model: device.model.as_deref() };
        let opened = set_up(&mut camera, identity, settings, restore)
            .and_then(|setup| Ok((setup, stream(&mut camera, settings)?)));
        match opened {
            Ok((mut setup, stream)) => {
                setup.clock = DeviceClock::read(camera.transport());
                let params = stream.params();
                let receiver = (std::net::SocketAddrV4::new(params.host, params.port), params.packet_size);
                let last_packet = last_packet(&stream, &camera, &setup);
                let speed = SlowRegister::new("SpindleSpeed", SPEED_PERIOD);
                let temperature = SlowRegister::new("DeviceTemperature", TEMPERATURE_PERIOD);
                Ok(Self { stream, camera, setup, receiver, last_packet, speed, temperature })
            }
            Err(why) => {
                restore.give_back(&mut camera);
                Err(why)
            }
        }
    }

    /// Begins to acquire.
    ///
    /// # Errors
    /// A camera that refuses, or is gone.
    pub(super) fn start(&mut self) -> Result<(), CameraError> {
        let packets = self.stream.stats().packets_received;
        if let Some(last_packet) = &mut self.last_packet {
            last_packet.begin(Instant::now(), packets);
        }
        self.camera.acquisition_start().map_err(|why| CameraError::failed("AcquisitionStart", why))
    }

    /// Stops the acquisition; the stream stays open.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub(super) fn stop(&mut self) -> Result<(), CameraError> {
        self.camera.acquisition_stop().map_err(|why| CameraError::failed("AcquisitionStop", why))
    }

    /// Its features, to be read.
    pub(super) fn features(&self) -> &impl Features {
        &self.camera
    }

    /// Its features, to be set.
    pub(super) fn features_mut(&mut self) -> &mut impl Features {
        &mut self.camera
    }

    /// Executes a command.
    ///
    /// # Errors
    /// The refusal of the camera or of its description, as text.
    pub(super) fn execute(&mut self, command: &str) -> Result<(), String> {
        self.camera.execute_command(command).map_err(|error| error.to_string())
    }

    /// The camera's clock, latched now, ns; `None` where it has no latch.
    pub(super) fn now_ns(&self) -> Option<u64> {
        self.setup.clock?.now_ns(self.camera.transport())
    }

    /// The next block, whole or not, after waiting at most so long; `None` where none came.
    ///
    /// # Errors
    /// A socket that fails.
    pub(super) fn receive(&mut self, wait: Duration) -> Result<Option<Block>, String> {
        let until = Instant::now() + wait;
        loop {
            let now = Instant::now();
            let left = until.saturating_duration_since(now);
            let look = self.last_packet.as_ref().map_or(left, |last_packet| last_packet.wait(now));
            match self.stream.next_frame_blocking(look.min(left)) {
                Ok(Some(block)) => return Ok(Some(self.received(block))),
                Ok(None) => return Err("its stream ended".to_owned()),
                Err(GenicamError::Timeout(_)) => {}
                Err(why) => return Err(why.to_string()),
            }
            let now = Instant::now();
            if let Some(last_packet) = &mut self.last_packet {
                last_packet.look(now, self.stream.stats().packets_received);
            }
            if now >= until {
                return Ok(None);
            }
        }
    }

    /// Notes that a block came.
    fn received(&mut self, block: Block) -> Block {
        let now = Instant::now();
        if let Some(last_packet) = &mut self.last_packet {
            last_packet.came(block.block_id, now, self.stream.stats().packets_received);
        }
        // A camera that sends answers, too.
        if let Some(clock) = &mut self.setup.clock {
            clock.keep(self.camera.transport(), now);
        }
        block
    }

    /// The values that came with a frame, otherwise those that the camera is set to.
    pub(super) fn values(&mut self, block: &Block) -> ChunkValues {
        self.setup.values(&mut self.camera, block)
    }

    /// Speed of the spindle that the head states, degrees a second; `None` where it states none.
    pub(super) fn spindle_deg_per_s(&mut self) -> Option<f64> {
        Some(DEG_PER_S * self.speed.value(&self.camera, Instant::now())?)
    }

    /// Temperature of the head, °C, by `DeviceTemperature` (SFNC 2.7) of the sensor that
    /// `DeviceTemperatureSelector` is set to.
    pub(super) fn head_c(&mut self) -> Option<Known<f64>> {
        let value = self.temperature.value(&self.camera, Instant::now())?;
        Some(Known { value, provenance: Provenance::Register })
    }

    /// Whether the camera, which answers, is still under this program's control.
    pub(super) fn has_control(&self) -> bool {
        matches!(self.camera.transport().refresh_control_state(), Ok(ControlState::Held))
    }

    /// Blocks of a payload that is no image.
    pub(super) fn unsupported(&self) -> u64 {
        self.stream.stats().frames_unsupported
    }

    /// Stops, restores what was set and gives control up.
    pub(super) fn close(mut self, restore: &mut Restore) {
        if let Err(why) = self.camera.acquisition_stop() {
            tracing::debug!("AcquisitionStop: {why}");
        }
        drop(self.stream);
        restore.give_back(&mut self.camera);
    }
}

fn of_connect(error: GenicamError) -> CameraError {
    match error {
        GenicamError::Gige {
            source: GigeError::Status(GigeStatus::Common(StatusCode::AccessDenied)),
            ..
        } => CameraError::Busy,
        other => CameraError::failed("the camera cannot be opened", other),
    }
}

/// Asks for last packets where the camera sends packets again and states the bytes of its frames.
fn last_packet(stream: &FrameStream, camera: &Device, setup: &Setup) -> Option<LastPacket> {
    let payload_bytes = camera.number("PayloadSize").filter(|bytes| *bytes >= 1.0)? as u32;
    let is_on = |mode: String| mode.eq_ignore_ascii_case("on") || mode == "true" || mode == "1";
    let is_long = camera.value("GevGVSPExtendedIDMode").is_some_and(is_on);
    let period = setup.period.filter(|_| !setup.is_triggered);
    let stated = Stated { payload_bytes, is_long, period };
    let is_sent_again = stream.resend_enabled();
    LastPacket::new(&stream.params(), stated, Instant::now()).filter(|_| is_sent_again)
}

fn stream(camera: &mut Device, settings: &CameraSettings) -> Result<FrameStream, CameraError> {
    let options = match settings.packet_bytes() {
        Some(text) => StreamOptions::new().packet_size(packet_bytes(text)?),
        None => StreamOptions::new().auto_packet_size(),
    };
    let mut stream =
        camera.open_stream(options).map_err(|why| CameraError::failed("the stream cannot be opened", why))?;
    // They are counted and named, not measured.
    stream.set_deliver_incomplete(true);
    Ok(stream)
}

fn packet_bytes(text: &str) -> Result<u32, CameraError> {
    text.parse().map_err(|_| CameraError::NotSet {
        feature: PACKET_SIZE.to_owned(),
        value: text.to_owned(),
        cause: "a number of bytes is needed, for instance 1500".to_owned(),
    })
}
