//! GigE Vision as the link to a live camera.

use std::time::Duration;

use viva_genicam::Frame as Block;
use viva_genicam::gige::DeviceInfo;

use super::chunks::ChunkValues;
use super::error::CameraError;
use super::find;
use super::guard::Restore;
use super::ids::Ids;
use super::link::{Link, Presence};
use super::session::Session;
use super::settings::CameraSettings;
use super::setup::Setup;
use super::watchdog::ANSWER;
use crate::source::live::Known;

impl Link for Session {
    type Device = DeviceInfo;

    const TICKS_ARE_NS: bool = false;

    fn find(name: &str) -> Result<DeviceInfo, CameraError> {
        find::find(name)
    }

    fn again(device: &DeviceInfo) -> Option<DeviceInfo> {
        find::at(device.ip, ANSWER).ok().flatten()
    }

    fn shown(device: &DeviceInfo) -> String {
        find::shown(device)
    }

    fn is_same(device: &DeviceInfo, other: &DeviceInfo) -> bool {
        device.serial == other.serial
    }

    fn open(
        device: &DeviceInfo,
        settings: &CameraSettings,
        restore: &mut Restore,
    ) -> Result<Self, CameraError> {
        Self::open(device, settings, restore)
    }

    fn setup(&self) -> &Setup {
        &self.setup
    }

    fn ids() -> Ids {
        Ids::new()
    }

    fn introduced(&self) -> String {
        let (receiver, bytes) = self.receiver;
        let bound_us = self.setup.clock.and_then(|clock| clock.bound_ns()).map(|ns| ns as f64 * 1e-3);
        format!("packets of {bytes} bytes to {receiver}, clock mapped within {bound_us:?} µs")
    }

    fn start(&mut self) -> Result<(), CameraError> {
        self.start()
    }

    fn receive(&mut self, wait: Duration) -> Result<Option<Block>, String> {
        self.receive(wait)
    }

    fn values(&mut self, block: &Block) -> ChunkValues {
        self.values(block)
    }

    fn spindle_deg_per_s(&mut self) -> Option<f64> {
        self.spindle_deg_per_s()
    }

    fn head_c(&mut self) -> Option<Known<f64>> {
        self.head_c()
    }

    /// Asked twice: a datagram may be lost.
    fn presence(&self, device: &DeviceInfo) -> Presence {
        let answers = (0..2).any(|_| matches!(find::at(device.ip, ANSWER), Ok(Some(_))));
        match answers {
            false => Presence::Absent,
            true if self.has_control() => Presence::Obeys,
            true => Presence::Lost,
        }
    }

    fn no_frames(&self, silent_s: f64) -> String {
        let (receiver, bytes) = self.receiver;
        match self.unsupported() {
            0 => format!(
                "it answers, but no frame came for {silent_s:.0} s: a firewall drops UDP to {receiver}, or the network \
                 does not carry packets of {bytes} bytes"
            ),
            blocks => format!("it sends {blocks} blocks that are no images: set it to a grey PixelFormat"),
        }
    }

    fn close(self, restore: &mut Restore) {
        self.close(restore);
    }
}
