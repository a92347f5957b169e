//! What a live camera requires of its link.

use std::time::Duration;

use viva_genicam::Frame as Block;

use super::chunks::ChunkValues;
use super::error::CameraError;
use super::guard::Restore;
use super::ids::Ids;
use super::settings::CameraSettings;
use super::setup::Setup;
use crate::source::live::Known;

/// Whether a camera that sends no frame is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Presence {
    /// It answers, and obeys this program.
    Obeys,
    /// It does not answer.
    Absent,
    /// It answers, and does not obey this program: it was restarted, or has another client.
    Lost,
}

/// A camera under control by one kind of link, with its stream open. The stream ends, and what was
/// set is restored, by `close`.
pub(crate) trait Link: Sized + Send + 'static {
    /// What discovery states of a camera, by which it is found again.
    type Device: Send;

    /// Whether the times of blocks are nanoseconds where no clock is known.
    const TICKS_ARE_NS: bool;

    /// The camera of a name.
    ///
    /// # Errors
    /// None, or more than one, of that name; a system without such a link.
    fn find(name: &str) -> Result<Self::Device, CameraError>;

    /// What is now where a camera was; `None` where nothing answers.
    fn again(device: &Self::Device) -> Option<Self::Device>;

    /// Maker, model, serial number and place of a camera.
    fn shown(device: &Self::Device) -> String;

    /// Whether both are one camera.
    fn is_same(device: &Self::Device, other: &Self::Device) -> bool;

    /// Takes control of a camera, sets it and opens its stream; nothing is acquired yet.
    ///
    /// # Errors
    /// A camera that is busy, gone, or set to what is not measured; what was set is restored.
    fn open(
        device: &Self::Device,
        settings: &CameraSettings,
        restore: &mut Restore,
    ) -> Result<Self, CameraError>;

    /// What the camera is set to.
    fn setup(&self) -> &Setup;

    /// Numbers of its blocks from the start.
    fn ids() -> Ids;

    /// How its frames come, in words, for the log.
    fn introduced(&self) -> String;

    /// Begins to acquire.
    ///
    /// # Errors
    /// A camera that refuses, or is gone.
    fn start(&mut self) -> Result<(), CameraError>;

    /// The next block, whole or not, after waiting at most so long; `None` where none came.
    ///
    /// # Errors
    /// A link that fails, in words.
    fn receive(&mut self, wait: Duration) -> Result<Option<Block>, String>;

    /// The values that came with a frame, otherwise those that the camera is set to.
    fn values(&mut self, block: &Block) -> ChunkValues;

    /// Speed of the spindle that the head states, degrees a second; `None` where it states none.
    fn spindle_deg_per_s(&mut self) -> Option<f64>;

    /// Temperature of the head, °C; `None` where it states none.
    fn head_c(&mut self) -> Option<Known<f64>>;

    /// Whether the camera, which is silent, is there.
    fn presence(&self, device: &Self::Device) -> Presence;

    /// Why no frame arrives of a camera that answers, in words.
    fn no_frames(&self, silent_s: f64) -> String;

    /// Stops, restores what was set and gives control up.
    fn close(self, restore: &mut Restore);
}
